#pragma once

// Tasks of one kind as one job of a scheduler: an array, in the words of most of them.

#include "runtime/farm/farm_task.hpp"

namespace runtime {

struct ArrayJob {
    std::string name;                  // of its task, or of the first and the last
    std::vector<std::uint32_t> tasks;  // into Cut::tasks; they follow one another
    std::vector<std::uint32_t> after;  // jobs that have to be done before; all stand before it
};

// Tasks of the stage `frames` that cook the same nodes and wait for the same tasks are one job, but
// no more than `most`; all others are jobs of their own.
std::vector<ArrayJob> array_jobs(const Cut& cut, std::size_t most);

}  // namespace runtime
