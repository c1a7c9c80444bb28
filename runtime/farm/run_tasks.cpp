#include "runtime/farm/run_tasks.hpp"

#include "runtime/farm/cut.hpp"
#include "runtime/farm/schedule.hpp"

#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

namespace runtime {

namespace {

struct Running {
    explicit Running(const Cut& cut)
        : left(seconds_to_end(cut)), dependants(dependants_of(cut)),
          ends(cut.tasks.size(), TaskEnd::not_run)
    {
        for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
            missing.push_back(cut.tasks[t].after.size());
            if (missing[t] == 0) ready.insert({-left[t], t});
        }
    }

    const std::vector<double> left;
    const std::vector<std::vector<std::uint32_t>> dependants;

    std::mutex mutex;  // guards what follows
    std::condition_variable_any changed;
    std::vector<std::size_t> missing;
    std::set<std::pair<double, std::uint32_t>> ready;  // most work behind it first
    std::size_t running = 0;
    std::vector<TaskEnd> ends;
    std::exception_ptr fatal;
};

// With the lock held.
void end_task(Running& all, std::uint32_t task, bool done)
{
    all.ends[task] = done ? TaskEnd::done : TaskEnd::failed;
    if (done) {
        for (const std::uint32_t t : all.dependants[task]) {
            if (--all.missing[t] == 0) all.ready.insert({-all.left[t], t});
        }
        return;
    }
    std::vector<std::uint32_t> blocked = all.dependants[task];
    while (!blocked.empty()) {
        const std::uint32_t t = blocked.back();
        blocked.pop_back();
        if (std::exchange(all.ends[t], TaskEnd::blocked) == TaskEnd::blocked) continue;
        blocked.insert(blocked.end(), all.dependants[t].begin(), all.dependants[t].end());
    }
}

void work(Running& all, const RunFarmTask& run, const std::stop_token& stop)
{
    std::unique_lock lock(all.mutex);
    for (;;) {
        all.changed.wait(lock, stop, [&] { return !all.ready.empty() || all.running == 0; });
        if (stop.stop_requested() || all.ready.empty() || all.fatal) break;
        const std::uint32_t task = all.ready.begin()->second;
        all.ready.erase(all.ready.begin());
        ++all.running;
        lock.unlock();
        bool done = false;
        std::exception_ptr trouble;
        try {
            done = run(task);
        } catch (...) {
            trouble = std::current_exception();
        }
        lock.lock();
        --all.running;
        if (trouble) all.fatal = trouble;
        // What was stopped did not fail.
        if (done || !stop.stop_requested()) end_task(all, task, done);
        all.changed.notify_all();
    }
    all.changed.notify_all();
}

}  // namespace

std::vector<TaskEnd> run_tasks(const Cut& cut, std::size_t at_once, const RunFarmTask& run,
                               const std::stop_token& stop)
{
    Running all(cut);
    {
        std::vector<std::jthread> threads;
        for (std::size_t i = 0; i < at_once; ++i) {
            threads.emplace_back([&] { work(all, run, stop); });
        }
    }
    if (all.fatal) std::rethrow_exception(all.fatal);
    return all.ends;
}

}  // namespace runtime
