#pragma once

// The engine `local`: a farm of one machine, whose tasks are processes of this program.

#include "runtime/commands/farm_job.hpp"

namespace runtime {

// Runs the job's tasks, `at_once` of them at a time (0: as many as the cores allow), and verifies
// what came out.
int run_local(const FarmJob& job, int at_once, Console& console);

}  // namespace runtime
