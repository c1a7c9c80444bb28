#pragma once

// One run of a task: its result is loaded from the disk cache, taken over from a run on equal
// contents, or made by the node.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Buffers that a worker uses for one run after the other.
struct Scratch {
    std::vector<std::vector<graph::Value>> inputs;  // by port
    std::vector<graph::Value> previous;
    std::vector<std::shared_ptr<const void>> prepared;

    void clear()
    {
        for (auto& port : inputs) port.clear();
        previous.clear(), prepared.clear();
    }
};

// Called without the lock. Whatever the node throws is in the outcome.
Outcome run_task(CookState& cook, Task& task, Scratch& scratch);

}  // namespace runtime
