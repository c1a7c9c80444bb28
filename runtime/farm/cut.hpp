#pragma once

// The pieces of several graphs as one list of tasks. What graphs share is made once, before them.

#include "runtime/farm/farm_task.hpp"
#include "runtime/farm/graph_pieces.hpp"

#include <vector>

namespace runtime {

struct ShotPieces {
    Shot shot;
    std::vector<int> frames;  // of the whole cook
    GraphPieces cut;
};

// `task_seconds`: a shot of less work is one task.
Cut join(const std::vector<ShotPieces>& shots, double task_seconds);

// What runs has to wait for, both ways: the tasks that wait for each.
std::vector<std::vector<std::uint32_t>> dependants_of(const Cut& cut);

}  // namespace runtime
