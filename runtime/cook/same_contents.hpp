#pragma once

// A node whose inputs hold the bytes that they held once before gives what it gave then: its result
// is found by the names of its inputs' contents, see Keys::by_content.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Whether the task need not run now: its result was met under the names of its inputs' contents
// (outcome.equal), or it was not and there are preparations to make first (outcome.other). Called
// without the lock.
bool compare_contents(CookState& cook, Task& task, Outcome& outcome);

}  // namespace runtime
