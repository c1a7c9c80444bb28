#pragma once

// Runs a cook: threads take ready tasks, run them without the lock, and end them with it.
//
//   lock    next_task() ─────────────┐      finish_run()  open_more()
//                                    v            ^             │
//   no lock                      run_task() ──────┘             └─> store on disk, report_events()
//
// A task that takes less than it takes to wake a thread is left to the first worker: several
// threads with such tasks only wait for each other's bookkeeping.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Cooks all that is wanted, with about `at_once` wants under way at a time. Called once for a
// state. Throws what the bookkeeping itself throws (std::bad_alloc); what nodes throw is a failure.
Cooked run_cook(CookState& cook, std::vector<Want> wants, std::size_t at_once);

}  // namespace runtime
