#pragma once

// Hands what happened in a cook to its observer: while nobody holds the lock, one thread at a time,
// in the order in which it happened.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Called without the lock, by any thread.
void report_events(CookState& cook);

}  // namespace runtime
