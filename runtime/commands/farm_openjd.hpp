#pragma once

// The engine `openjd`: a job template of Open Job Description, 2023-09, which Deadline Cloud and
// other schedulers take. Its tasks are those of Slurm; `aspic cook --openjd` tells how far they
// are.

#include "runtime/commands/farm_job.hpp"

namespace runtime {

std::string openjd_template(const FarmJob& job);

// Throws std::invalid_argument where the job holds what no template can say.
void check_for_openjd(const FarmJob& job);

// Writes farm/job.template.json and says where it is.
void write_openjd(const FarmJob& job, Console& console);

}  // namespace runtime
