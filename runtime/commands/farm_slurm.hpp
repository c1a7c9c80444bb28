#pragma once

// The engine `slurm`: scripts for sbatch that a person can read and send again, and what squeue and
// scancel know of them.
//
//   farm/jobs/JOB.sbatch   a task, or an array of tasks
//   farm/submit.sh         sends them all, each after those that it waits for
//   farm/jobs.txt          name and number of each job that was sent
//   farm/slurm.log         what Slurm itself says of the jobs

#include "runtime/commands/farm_job.hpp"
#include "runtime/farm/array_jobs.hpp"

namespace runtime {

// Longer arrays are several: Slurm's own limit, if nobody raised it, is 1,000.
inline constexpr std::size_t longest_array = 1000;

std::string sbatch_script(const FarmJob& job, const ArrayJob& array);
std::string submit_script(const FarmJob& job, const std::vector<ArrayJob>& jobs);

// Throws std::invalid_argument where a name of the job is none that Slurm's scripts can hold.
void check_for_slurm(const FarmJob& job);

// Writes the scripts and sends them. Throws std::runtime_error with what Slurm said against it.
void send_to_slurm(const FarmJob& job, Console& console);

// Of a job that was sent: what squeue says of each of its tasks that is in the queue, by name.
struct Queued {
    std::string state, machine;  // "RUNNING", "n0"
};
std::map<std::string, Queued> queued_tasks(const FarmJob& job, Console& console);

// Ends all that is in the queue. Throws std::runtime_error with what Slurm said against it.
void cancel_slurm(const FarmJob& job, Console& console);

}  // namespace runtime
