#include "runtime/commands/farm_status.hpp"

#include "graph/document/problem.hpp"
#include "runtime/commands/farm_slurm.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ostream>
#include <thread>

namespace runtime {

namespace {

namespace fs = std::filesystem;

enum class Fate : std::uint8_t { done, running, waiting, failed, not_run };

bool is_complete(const fs::path& manifest, fs::file_time_type since)
{
    std::error_code error;
    const auto written = fs::last_write_time(manifest, error);
    if (error || written < since) return false;
    try {
        return read_manifest(manifest).complete;
    } catch (const std::invalid_argument&) {
        return false;
    }
}

struct Fates {
    std::vector<Fate> of;  // by task
    std::array<std::size_t, 5> count{};
};

Fates fates_of(const FarmJob& job, const std::map<std::string, Queued>& queued)
{
    Fates fates;
    std::error_code error;
    const auto since = fs::last_write_time(job.folder / "plan.json", error);
    for (const FarmTask& task : job.cut.tasks) {
        const bool last = task.stage == Stage::last;
        const fs::path manifest =
            last ? job.cut.shots[task.shot].folder / manifest_name : job.part(task);
        const auto q = queued.find(task.name);
        const Fate fate = q != queued.end()
                              ? (q->second.state == "PENDING" ? Fate::waiting : Fate::running)
                          : is_complete(manifest, since) ? Fate::done
                          : fs::exists(job.log(task))    ? Fate::failed
                                                         : Fate::not_run;
        fates.of.push_back(fate);
        ++fates.count[static_cast<std::size_t>(fate)];
    }
    return fates;
}

// " on n0": what the task's log says of its machine.
std::string machine_in(const FarmJob& job, const FarmTask& task)
{
    const std::string text = read_text(job.log(task));
    const std::string before = "task " + task.name + " on ";
    const std::size_t at = text.rfind(before);
    if (at == std::string::npos) return "";  // of the engine `local`
    const std::size_t begin = at + before.size();
    return " on " + text.substr(begin, text.find_first_of(",\n", begin) - begin);
}

// What to do about tasks that are not done, of which none is in the queue.
std::string advice(const FarmJob& job, bool began)
{
    if (began) return "the same farm command cooks what is missing\n";
    for (const char* const name : {"job.template.json", "submit.sh"}) {
        if (!fs::exists(job.folder / name)) continue;
        return fmt::format("nothing has run: give {} to the scheduler\n",
                           (job.folder / name).string());
    }
    return "nothing has run: give the farm command again\n";
}

}  // namespace

std::string trouble_in(const FarmJob& job, const FarmTask& task)
{
    std::string text;
    try {
        text = read_text(job.log(task));
    } catch (const std::invalid_argument&) {
        return {};
    }
    std::string errors, last;
    for (std::size_t at = 0; at < text.size();) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        last = "  " + text.substr(at, end - at) + "\n";
        if (text.compare(at, 5, "error") == 0 || text.compare(at, 6, "missed") == 0) errors += last;
        at = end + 1;
    }
    return errors.empty() ? last : errors;
}

int farm_status(const FarmJob& job, Console& console)
{
    const std::map<std::string, Queued> queued = queued_tasks(job, console);
    const Fates fates = fates_of(job, queued);
    const auto count = [&](Fate fate) { return fates.count[static_cast<std::size_t>(fate)]; };
    console.out << fmt::format(
        "{} of {} tasks are done, {} run, {} wait, {} failed, {} did not run\n", count(Fate::done),
        job.cut.tasks.size(), count(Fate::running), count(Fate::waiting), count(Fate::failed),
        count(Fate::not_run));
    for (std::size_t t = 0; t < job.cut.tasks.size(); ++t) {
        const FarmTask& task = job.cut.tasks[t];
        if (fates.of[t] == Fate::running) {
            console.out << fmt::format("  {} runs on {}\n", task.name,
                                       queued.at(task.name).machine);
        } else if (fates.of[t] == Fate::failed) {
            console.out << fmt::format("  {} (frames {}) failed{}; its log is {}\n{}", task.name,
                                       frames_text(task.frames), machine_in(job, task),
                                       job.log(task).string(), trouble_in(job, task));
        }
    }
    if (count(Fate::done) == job.cut.tasks.size()) {
        return verify_job(job, console);
    }
    if (!queued.empty()) return exit_ok;
    console.err << advice(job, count(Fate::done) + count(Fate::failed) > 0);
    return exit_failed;
}

int wait_for_slurm(const FarmJob& job, Console& console)
{
    while (!queued_tasks(job, console).empty()) {
        if (console.stop.stop_requested()) {
            cancel_slurm(job, console);
            return exit_cancelled;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
    return farm_status(job, console);
}

int farm_logs(const FarmJob& job, const std::string& name, Console& console)
{
    const auto called = [&](const FarmTask& task) { return task.name == name; };
    const auto& tasks = job.cut.tasks;
    if (!name.empty() && std::none_of(tasks.begin(), tasks.end(), called)) {
        std::vector<std::string_view> names;
        for (const FarmTask& task : tasks) names.push_back(task.name);
        const std::string near = graph::suggest(name, names);
        throw std::invalid_argument(
            fmt::format("no task is called '{}'{}{}", name, near.empty() ? "" : "; ", near));
    }
    const Fates fates = fates_of(job, queued_tasks(job, console));
    std::size_t shown = 0;
    for (std::size_t t = 0; t < job.cut.tasks.size(); ++t) {
        const FarmTask& task = job.cut.tasks[t];
        if (name.empty() ? fates.of[t] != Fate::failed : task.name != name) continue;
        if (!fs::exists(job.log(task))) {
            console.err << fmt::format("{} did not run\n", task.name);
            continue;
        }
        ++shown;
        console.out << fmt::format("==> {} <==\n{}", task.name, read_text(job.log(task)));
    }
    if (shown == 0 && name.empty()) {
        console.err << fmt::format(
            "no task failed; --task NAME shows what any said, as --task {}\n", tasks.back().name);
    }
    return shown > 0 ? exit_ok : exit_failed;
}

}  // namespace runtime
