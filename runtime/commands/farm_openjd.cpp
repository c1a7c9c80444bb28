// https://github.com/OpenJobDescription/openjd-specifications/wiki/2023-09-Template-Schemas

#include "runtime/commands/farm_openjd.hpp"

#include "runtime/commands/manifest.hpp"
#include "runtime/commands/text_file.hpp"
#include "runtime/farm/array_jobs.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <stdexcept>

namespace runtime {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_values = 1000;  // of a parameter: 1,024 are allowed
constexpr std::size_t longest_value = 1024;
constexpr std::size_t longest_name = 64;  // of a step
constexpr std::size_t longest_job_name = 128;

bool is_control(char c)
{
    return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
}

// What is only shown, without control characters and braces that mean something.
std::string shown(std::string text)
{
    std::replace_if(text.begin(), text.end(), is_control, ' ');
    for (std::size_t at = 0; (at = text.find("{{", at)) != std::string::npos;) text[at] = '(';
    return text;
}

// The last bytes of a text, whole characters of UTF-8.
std::string end_of(const std::string& text, std::size_t most)
{
    std::size_t at = text.size() - std::min(most, text.size());
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80) ++at;
    return text.substr(at);
}

// The name, or one of the allowed length that is as unlike others.
std::string step_name(const std::vector<ArrayJob>& jobs, std::size_t j)
{
    const std::string name = shown(jobs[j].name);
    if (name.size() <= longest_name && name == jobs[j].name) return name;
    const std::string number = fmt::format("{}: ", j + 1);
    return number + end_of(name, longest_name - number.size());
}

std::string job_name(const Cut& cut)
{
    const std::string others =
        cut.shots.size() > 1 ? fmt::format(" and {} more", cut.shots.size() - 1) : "";
    return end_of(shown(cut.shots.at(0).name), longest_job_name - others.size()) + others;
}

// Whether a text is UTF-8, without the control characters of its second 128.
bool is_plain_utf8(const std::string& text)
{
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
        const auto next = static_cast<unsigned char>(text[i + 1]);
        if (text[i] == '\xc2' && next >= 0x80 && next < 0xa0) return false;
    }
    try {
        return !Json(text).dump().empty();
    } catch (const Json::exception&) {
        return false;
    }
}

// What a task is given as it is: a template has no way to say "{{" or a control character.
const std::string& given(const std::string& text)
{
    if (text.find("{{") == std::string::npos &&
        std::none_of(text.begin(), text.end(), is_control) && is_plain_utf8(text)) {
        return text;
    }
    std::string told = text;
    std::replace_if(told.begin(), told.end(), is_control, ' ');
    throw std::invalid_argument(fmt::format(
        "Open Job Description: expected paths, names and settings in UTF-8 with neither '{{{{' nor "
        "control characters, found '{}'; rename it, or use another engine",
        told));
}

// What differs from task to task comes from the step's parameters.
Json arguments(const FarmJob& job, const ArrayJob& array)
{
    const std::vector<std::string> words = words_of(job, job.cut.tasks[array.tasks.front()]);
    Json args = Json::array();
    for (std::size_t i = 1; i < words.size(); ++i) {
        if (array.tasks.size() > 1 && words[i - 1] == "--frames") {
            args.push_back("{{Task.Param.Frames}}");
        } else if (array.tasks.size() > 1 && words[i - 1] == "--part") {
            args.push_back(given((job.folder / "parts").string()) + "/{{Task.Param.Task}}.json");
        } else {
            args.push_back(given(words[i]));
        }
    }
    args.push_back("--openjd");
    return args;
}

Json parameter_space(const FarmJob& job, const ArrayJob& array)
{
    Json tasks = Json::array(), frames = Json::array();
    for (const std::uint32_t t : array.tasks) {
        tasks.push_back(given(job.cut.tasks[t].name));
        frames.push_back(frames_text(job.cut.tasks[t].frames));
    }
    return {{"taskParameterDefinitions",
             Json::array({{{"name", "Task"}, {"type", "STRING"}, {"range", std::move(tasks)}},
                          {{"name", "Frames"}, {"type", "STRING"}, {"range", std::move(frames)}}})},
            {"combination", "(Task, Frames)"}};
}

// What a task was measured to take, twice as much of memory.
Json requirements(const FarmJob& job, const ArrayJob& array)
{
    const UsedResources measured = job.measured_of(job.cut.tasks[array.tasks.front()]);
    Json amounts = Json::array();
    const int threads = job.request.threads > 0 ? job.request.threads : measured.threads();
    if (threads > 0) amounts.push_back({{"name", "amount.worker.vcpu"}, {"min", threads}});
    if (measured.memory > 0) {
        const double megabytes = 2 * static_cast<double>(measured.memory) / (1 << 20);
        amounts.push_back(
            {{"name", "amount.worker.memory"}, {"min", static_cast<int>(std::ceil(megabytes))}});
    }
    return amounts;
}

Json step(const FarmJob& job, const std::vector<ArrayJob>& jobs, std::size_t j)
{
    const ArrayJob& array = jobs[j];
    Json step;
    step["name"] = step_name(jobs, j);
    for (const std::uint32_t before : array.after) {
        step["dependencies"].push_back({{"dependsOn", step_name(jobs, before)}});
    }
    const Json amounts = requirements(job, array);
    if (!amounts.empty()) step["hostRequirements"]["amounts"] = amounts;
    if (array.tasks.size() > 1) step["parameterSpace"] = parameter_space(job, array);
    step["script"]["actions"]["onRun"] = {{"command", given(job.program.string())},
                                          {"args", arguments(job, array)}};
    return step;
}

}  // namespace

std::string openjd_template(const FarmJob& job)
{
    // Frames that lie scattered take a long text: then a step is one task, whose frames are an
    // argument, and these may be of any length.
    const bool fits =
        std::all_of(job.cut.tasks.begin(), job.cut.tasks.end(), [](const FarmTask& task) {
            return task.stage != Stage::frames || frames_text(task.frames).size() <= longest_value;
        });
    const std::vector<ArrayJob> jobs = array_jobs(job.cut, fits ? most_values : 1);
    Json json;
    json["specificationVersion"] = "jobtemplate-2023-09";
    json["name"] = job_name(job.cut);
    json["steps"] = Json::array();
    for (std::size_t j = 0; j < jobs.size(); ++j) json["steps"].push_back(step(job, jobs, j));
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void check_for_openjd(const FarmJob& job)
{
    openjd_template(job);
}

void write_openjd(const FarmJob& job, Console& console)
{
    const std::filesystem::path path = job.folder / "job.template.json";
    replace_text(path, openjd_template(job));
    console.out << fmt::format("job template: {}\n", path.string());
}

}  // namespace runtime
