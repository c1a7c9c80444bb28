#pragma once

// How long a cut takes: the longest path through its tasks, and what n machines make of it when
// each takes the ready task that most work waits for.

#include "runtime/farm/farm_task.hpp"

#include <vector>

namespace runtime {

// By task: s from its beginning to the end of all, if machines never ran out.
std::vector<double> seconds_to_end(const Cut& cut);

// The tasks of the longest path, first one first.
std::vector<std::uint32_t> critical_path(const Cut& cut);

// s until all is done on so many machines, one task at a time on each. `overhead`: s that each task
// takes beside its work.
double makespan(const Cut& cut, std::size_t machines, double overhead = 0);

}  // namespace runtime
