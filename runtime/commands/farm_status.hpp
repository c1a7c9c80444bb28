#pragma once

// What became of a farm's tasks, told from the folder that they share and from the scheduler.

#include "runtime/commands/farm_job.hpp"

namespace runtime {

// How many tasks are done, run, wait or failed, and why those failed. When all are done, what came
// out is verified. exit_ok: that is so, or some still run.
int farm_status(const FarmJob& job, Console& console);

// Waits until none of the tasks is in Slurm's queue, then tells their status. When it is to stop,
// it cancels them.
int wait_for_slurm(const FarmJob& job, Console& console);

// What tasks said: the one of that name, or all that failed.
int farm_logs(const FarmJob& job, const std::string& task, Console& console);

// The lines of the task's log that tell of trouble; the last one where none does.
std::string trouble_in(const FarmJob& job, const FarmTask& task);

}  // namespace runtime
