#pragma once

// Runs the tasks of a cut, some at once, each after those that it waits for.

#include "runtime/farm/farm_task.hpp"

#include <functional>
#include <stop_token>
#include <vector>

namespace runtime {

enum class TaskEnd : std::uint8_t {
    not_run,  // it was stopped before
    done,
    failed,
    blocked,  // it waits for one that failed
};

// Runs one task and returns whether it is done. Called from several threads at once.
using RunFarmTask = std::function<bool(std::uint32_t task)>;

// The ready task that most work waits for goes first. One that fails stops what depends on it and
// nothing else. Returns how each task ended.
std::vector<TaskEnd> run_tasks(const Cut& cut, std::size_t at_once, const RunFarmTask& run,
                               const std::stop_token& stop);

}  // namespace runtime
