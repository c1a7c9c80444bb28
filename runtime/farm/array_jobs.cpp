#include "runtime/farm/array_jobs.hpp"

#include <algorithm>

namespace runtime {

namespace {

bool alike(const FarmTask& a, const FarmTask& b)
{
    return a.stage == Stage::frames && b.stage == Stage::frames && a.shot == b.shot &&
           a.nodes == b.nodes && a.after == b.after;
}

// "frames-3" of "chair.frames-3" and what follows: "chair.frames-3-to-8".
std::string name_of_all(const FarmTask& first, const FarmTask& last)
{
    return first.name + "-to-" + last.name.substr(last.name.rfind('-') + 1);
}

}  // namespace

std::vector<ArrayJob> array_jobs(const Cut& cut, std::size_t most)
{
    std::vector<ArrayJob> jobs;
    std::vector<std::uint32_t> job_of;
    for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
        const FarmTask& task = cut.tasks[t];
        const bool one_more =
            t > 0 && alike(cut.tasks[t - 1], task) && jobs.back().tasks.size() < most;
        if (!one_more) {
            ArrayJob job{task.name, {}, {}};
            for (const std::uint32_t before : task.after) job.after.push_back(job_of[before]);
            std::sort(job.after.begin(), job.after.end());
            job.after.erase(std::unique(job.after.begin(), job.after.end()), job.after.end());
            jobs.push_back(std::move(job));
        }
        jobs.back().tasks.push_back(t);
        job_of.push_back(static_cast<std::uint32_t>(jobs.size() - 1));
    }
    for (ArrayJob& job : jobs) {
        if (job.tasks.size() == 1) continue;
        job.name = name_of_all(cut.tasks[job.tasks.front()], cut.tasks[job.tasks.back()]);
    }
    return jobs;
}

}  // namespace runtime
