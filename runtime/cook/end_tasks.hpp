#pragma once

// From what is done or failed down to what waits for it. A result leaves its task when the last
// task that needs it has run.
//
// All of these are called with the lock held.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Everything that the task needs is there: puts it in the queue of those that may run.
void make_ready(CookState& cook, Task& task);

// One of the task's inputs is there.
void input_arrived(CookState& cook, Task& task);

// The task has its result: tells what waits for it.
void arrive(CookState& cook, Task& task, SharedResult result);

// Hands a wanted result to the observers.
void deliver(CookState& cook, std::uint32_t want, const SharedResult& result);

// The task failed by itself. All that depends on it fails too.
void fail(CookState& cook, Task& task, std::string what);

// Something that the task depends on failed.
void block(CookState& cook, Task& task);

// One user less; null is allowed. What nobody needs leaves, and what only it needed with it.
void release(CookState& cook, Task* first);

}  // namespace runtime
