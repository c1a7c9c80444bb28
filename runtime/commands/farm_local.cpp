#include "runtime/commands/farm_local.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/farm_status.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/cook/task.hpp"
#include "runtime/farm/run_tasks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <ostream>
#include <thread>
#include <unistd.h>

namespace runtime {

namespace {

std::string machine_name()
{
    std::array<char, 256> name{};
    ::gethostname(name.data(), name.size() - 1);
    return name.data();
}

std::string how_it_ended(int exit)
{
    if (exit > 128) return fmt::format("was killed by signal {}", exit - 128);
    if (exit < 0) return "could not be started";
    return fmt::format("failed with exit code {}", exit);
}

class LocalFarm {
public:
    LocalFarm(const FarmJob& job, Console& console) : job_(job), console_(console) {}

    bool run(std::uint32_t t)
    {
        const FarmTask& task = job_.cut.tasks[t];
        const Clock::time_point begin = Clock::now();
        const int exit =
            console_.run_program(said_into(job_.log(task), words_of(job_, task)), console_.stop);
        const double seconds = seconds_since(begin);
        const std::lock_guard lock(mutex_);
        // An expectation that was missed is told at the end: the files are there.
        const bool done = exit == exit_ok || exit == exit_missed;
        if (console_.stop.stop_requested()) return done;
        if (!done) {
            console_.err << fmt::format("error: task {} ({}) {} on {}; its log is {}\n{}",
                                        task.name, what(task), how_it_ended(exit), machine_name(),
                                        job_.log(task).string(), trouble_in(job_, task));
        } else if (!job_.request.quiet) {
            console_.err << fmt::format("{} of {}, {}: {} ({})\n", ++count_, job_.cut.tasks.size(),
                                        format_seconds(seconds), task.name, what(task));
        }
        return done;
    }

private:
    static std::string what(const FarmTask& task)
    {
        return (task.frames.size() == 1 ? "frame " : "frames ") + frames_text(task.frames);
    }

    const FarmJob& job_;
    Console& console_;
    std::mutex mutex_;
    std::size_t count_ = 0;
};

}  // namespace

int run_local(const FarmJob& job, int at_once, Console& console)
{
    if (!console.run_program) throw std::invalid_argument("farm: no programs can be run here");
    const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    const int threads = job.request.threads > 0 ? job.request.threads : cores;
    const int count = at_once > 0 ? at_once : std::max(1, cores / threads);
    LocalFarm farm(job, console);
    const std::vector<TaskEnd> ends = run_tasks(
        job.cut, static_cast<std::size_t>(count), [&farm](std::uint32_t t) { return farm.run(t); },
        console.stop);
    if (console.stop.stop_requested()) return exit_cancelled;
    const auto failed = std::count(ends.begin(), ends.end(), TaskEnd::failed);
    const auto blocked = std::count(ends.begin(), ends.end(), TaskEnd::blocked);
    if (failed > 0) {
        console.err << fmt::format(
            "{} of {} tasks failed, {} wait for them; the same command goes on from the cache\n",
            failed, ends.size(), blocked);
        return exit_failed;
    }
    return verify_job(job, console);
}

}  // namespace runtime
