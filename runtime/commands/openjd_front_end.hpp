#pragma once

// A cook shown to a scheduler of Open Job Description: lines that it looks for in what a task
// prints, among those for people.
//
//   openjd_progress: 12.5            percent
//   openjd_status: 3 of 24 results
//   openjd_fail: why the task is about to fail

#include "runtime/commands/front_end.hpp"

namespace runtime {

std::unique_ptr<FrontEnd> openjd_front_end(Console& console);

}  // namespace runtime
