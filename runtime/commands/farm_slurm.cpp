#include "runtime/commands/farm_slurm.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace runtime {

namespace {

namespace fs = std::filesystem;

// What a task may take, from what tasks of its kind took before, generously.
std::string resources(const FarmJob& job, const ArrayJob& array)
{
    const FarmTask& first = job.cut.tasks[array.tasks.front()];
    const UsedResources measured = job.measured_of(first);
    const int threads = job.request.threads > 0 ? job.request.threads : measured.threads();
    std::string text = fmt::format("#SBATCH --cpus-per-task={}\n", std::max(threads, 1));
    if (measured.memory > 0) {
        constexpr double step = 64 << 20;
        const double bytes = std::max(2.0 * static_cast<double>(measured.memory), 4 * step);
        text += fmt::format("#SBATCH --mem={}M\n", 64 * static_cast<int>(std::ceil(bytes / step)));
    }
    if (job.cut.shots[first.shot].measured) {
        double longest = 0;
        for (const std::uint32_t t : array.tasks) {
            longest = std::max(longest, job.cut.tasks[t].seconds);
        }
        text += fmt::format("#SBATCH --time={}\n", 15 + static_cast<int>(std::ceil(longest / 6)));
    }
    for (const std::string& option : job.sbatch) text += "#SBATCH " + option + "\n";
    return text;
}

// The command of the tasks: what differs from task to task comes from shell variables.
std::string command(const FarmJob& job, const ArrayJob& array)
{
    const FarmTask& first = job.cut.tasks[array.tasks.front()];
    std::string line;
    std::string before;
    for (const std::string& word : words_of(job, first)) {
        std::string text = shell_line({word});
        if (array.tasks.size() > 1 && before == "--frames") {
            text = "\"${frames[SLURM_ARRAY_TASK_ID - 1]}\"";
        } else if (array.tasks.size() > 1 && before == "--part") {
            text = shell_line({(job.folder / "parts").string()}) + "/$task.json";
        }
        const bool option = word.starts_with("--");
        line += (line.empty() ? "" : option ? " \\\n    " : " ") + text;
        before = word;
    }
    if (job.request.threads == 0) line += " \\\n    --threads \"$SLURM_CPUS_PER_TASK\"";
    return line;
}

// What sbatch and its like print, and their exit status.
struct Answer {
    int status = -1;
    std::string text;
};
Answer ask(const FarmJob& job, const std::vector<std::string>& words, Console& console)
{
    const fs::path file = job.folder / "answer.txt";
    Answer answer;
    answer.status =
        console.run_program ? console.run_program(said_into(file, words), console.stop) : -1;
    if (answer.status >= 0) answer.text = read_text(file);
    std::error_code ignored;
    fs::remove(file, ignored);
    if (answer.status == 127) {
        throw std::runtime_error(words.front() + " is not there: is this a machine of the farm?");
    }
    return answer;
}

// Number and name of each job that was sent.
std::vector<std::pair<std::string, std::string>> sent_jobs(const FarmJob& job)
{
    std::vector<std::pair<std::string, std::string>> jobs;
    if (!fs::exists(job.folder / "jobs.txt")) return jobs;
    std::istringstream in(read_text(job.folder / "jobs.txt"));
    std::string name, number;
    while (in >> name >> number) jobs.emplace_back(number, name);
    return jobs;
}

std::string numbers_of(const FarmJob& job)
{
    std::vector<std::string> numbers;
    for (const auto& sent : sent_jobs(job)) numbers.push_back(sent.first);
    return fmt::format("{}", fmt::join(numbers, ","));
}

// Names stand in scripts, lists and patterns of Slurm, which have no quotes for them.
void check_name(const std::string& name)
{
    const auto odd = [](char c) {
        return static_cast<unsigned char>(c) <= ' ' || c == '\x7f' ||
               std::string_view("%\"'`$\\*?[]<>|&;#").find(c) != std::string_view::npos;
    };
    if (std::none_of(name.begin(), name.end(), odd)) return;
    std::string shown = name;
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; },
        ' ');
    throw std::invalid_argument(
        "Slurm: expected names of documents and of the output folder without spaces and signs that "
        "mean something to a shell or to Slurm, found '" +
        shown + "'; rename it, or use another engine");
}

}  // namespace

std::string sbatch_script(const FarmJob& job, const ArrayJob& array)
{
    const FarmTask& first = job.cut.tasks[array.tasks.front()];
    const bool many = array.tasks.size() > 1;
    std::string text = "#!/bin/bash\n#SBATCH --job-name=" + array.name + "\n";
    if (many) text += fmt::format("#SBATCH --array=1-{}\n", array.tasks.size());
    text += resources(job, array);
    text += "#SBATCH --requeue\n#SBATCH --open-mode=append\n#SBATCH --output=" +
            (job.folder / "slurm.log").string() + "\n";
    text += fmt::format("# {}: {}, {} task{}, {} of work.\n", job.cut.shots[first.shot].name,
                        first.stage == Stage::sweep ? "table and sheet of all settings"
                        : first.nodes.empty()
                            ? "the whole cook"
                            : fmt::format("of {} what is missing", fmt::join(first.nodes, ", ")),
                        array.tasks.size(), many ? "s" : "", format_seconds([&] {
                            double sum = 0;
                            for (const auto t : array.tasks) sum += job.cut.tasks[t].seconds;
                            return sum;
                        }()));
    if (many) {
        text += "frames=(";
        for (const std::uint32_t t : array.tasks) {
            text += (text.back() == '(' ? "" : " ") + frames_text(job.cut.tasks[t].frames);
        }
        const std::size_t dash = first.name.rfind('-');
        const int before = std::stoi(first.name.substr(dash + 1)) - 1;
        text += fmt::format(")\ntask={}$((SLURM_ARRAY_TASK_ID + {}))\n",
                            shell_line({first.name.substr(0, dash + 1)}), before);
    } else {
        text += "task=" + shell_line({first.name}) + "\n";
    }
    text += "exec >>" + shell_line({(job.folder / "logs").string()}) + "/$task.log 2>&1\n";
    text += "echo \"task $task on ${SLURMD_NODENAME:-$(hostname)}, job $SLURM_JOB_ID\"\n";
    return text + "exec " + command(job, array) + "\n";
}

std::string submit_script(const FarmJob& job, const std::vector<ArrayJob>& jobs)
{
    std::string text =
        "#!/bin/bash\n"
        "# Sends the tasks to Slurm, each after those that it waits for.\n"
        "set -e\n"
        "cd " +
        shell_line({job.folder.string()}) +
        "\n"
        ": >jobs.txt\n"
        "send() {  # JOB [OPTION]\n"
        "    id=$(sbatch --parsable --kill-on-invalid-dep=yes $2 \"jobs/$1.sbatch\")\n"
        "    id=${id%%;*}\n"
        "    echo \"$1 $id\" >>jobs.txt\n"
        "}\n";
    for (std::size_t j = 0; j < jobs.size(); ++j) {
        text += "send " + shell_line({jobs[j].name});
        std::string after;
        for (const std::uint32_t before : jobs[j].after) after += fmt::format(":$j{}", before + 1);
        if (!after.empty()) text += " --dependency=afterok" + after;
        text += fmt::format("; j{}=$id\n", j + 1);
    }
    return text;
}

void check_for_slurm(const FarmJob& job)
{
    check_name(job.folder.string());
    for (const ArrayJob& array : array_jobs(job.cut, longest_array)) check_name(array.name);
}

void send_to_slurm(const FarmJob& job, Console& console)
{
    const std::vector<ArrayJob> jobs = array_jobs(job.cut, longest_array);
    for (const ArrayJob& array : jobs) {
        replace_text(job.folder / "jobs" / (array.name + ".sbatch"), sbatch_script(job, array));
    }
    const fs::path script = job.folder / "submit.sh";
    replace_text(script, submit_script(job, jobs));
    const Answer sent = ask(job, {"bash", script.string()}, console);
    if (sent.status != 0) {
        throw std::runtime_error(fmt::format(
            "the tasks could not be sent to Slurm; mend what sbatch says below, or run {} where "
            "sbatch works\n{}",
            script.string(), sent.text.substr(0, sent.text.find_last_not_of('\n') + 1)));
    }
    console.out << fmt::format("sent: {} task{} in {} job{}, by {}\n", job.cut.tasks.size(),
                               job.cut.tasks.size() == 1 ? "" : "s", jobs.size(),
                               jobs.size() == 1 ? "" : "s", script.string());
    console.out.flush();
}

std::map<std::string, Queued> queued_tasks(const FarmJob& job, Console& console)
{
    std::map<std::string, Queued> queued;
    const std::string numbers = numbers_of(job);
    if (numbers.empty()) return queued;
    std::map<std::string, std::uint32_t> first_of;
    for (const ArrayJob& array : array_jobs(job.cut, longest_array)) {
        first_of[array.name] = array.tasks.front();
    }
    const Answer answer =
        ask(job, {"squeue", "-h", "-r", "-o", "%j %K %T %N", "-j", numbers}, console);
    // Jobs that ended long ago are unknown to it: that is no failure.
    std::istringstream lines(answer.status == 0 ? answer.text : "");
    for (std::string line; std::getline(lines, line);) {
        std::istringstream in(line);
        std::string name, place;
        Queued q;
        in >> name >> place >> q.state >> q.machine;
        const auto found = first_of.find(name);
        if (found == first_of.end()) continue;
        const bool array = place.find_first_not_of("0123456789") == std::string::npos;
        const std::size_t offset = array && place != "0" ? std::stoul(place) - 1 : 0;
        if (found->second + offset < job.cut.tasks.size()) {
            queued[job.cut.tasks[found->second + offset].name] = q;
        }
    }
    return queued;
}

void cancel_slurm(const FarmJob& job, Console& console)
{
    std::vector<std::string> words{"scancel"};
    for (const auto& sent : sent_jobs(job)) words.push_back(sent.first);
    if (words.size() == 1) return;
    const Answer answer = ask(job, words, console);
    if (answer.status == 0) return;
    throw std::runtime_error("the tasks could not be cancelled; scancel says: " + answer.text);
}

}  // namespace runtime
