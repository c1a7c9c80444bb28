#pragma once

// The folder that a farm's tasks share beside the cache, and the command line of each of them.
//
//   out/NAME/farm/plan.json          the cut, as `farm --plan --json` shows it
//   out/NAME/farm/parts/TASK.json    what a task made, what that took and on which machine
//   out/NAME/farm/logs/TASK.log      what it said
//   out/NAME/farm/measured.json      what tasks of each kind took, of this job's earlier runs too

#include "runtime/commands/farm_plan.hpp"

#include <algorithm>
#include <map>

namespace runtime {

// The most that tasks of one kind took.
struct UsedResources {
    std::uint64_t memory = 0;  // bytes; 0: not measured
    double cores = 0;          // on average; 0: not measured

    // That a task of this kind keeps busy; 0: not measured. Compression beside the one thread of a
    // task is no reason to ask for a second core, which a small node may not have.
    int threads() const { return cores > 0 ? static_cast<int>(std::max(1.0, cores + 0.5)) : 0; }
};

struct FarmJob {
    Cut cut;
    std::filesystem::path folder;  // absolute
    std::filesystem::path cache;   // absolute
    std::filesystem::path program;
    CookRequest request;
    std::vector<std::string> sbatch;                // options for Slurm
    std::vector<std::string> vary;                  // as --vary takes them
    std::map<std::string, UsedResources> measured;  // by shot and stage: "bridge.frames"

    UsedResources measured_of(const FarmTask& task) const;
    std::filesystem::path part(const FarmTask& task) const
    {
        return folder / "parts" / (task.name + ".json");
    }
    std::filesystem::path log(const FarmTask& task) const
    {
        return folder / "logs" / (task.name + ".log");
    }
};

// Where the job of these documents is, absolute.
std::filesystem::path farm_folder(const CookRequest& request);

// Of a job that was begun before. Throws std::invalid_argument when there is none.
FarmJob read_job(const CookRequest& request);

// A job that nothing was written of yet. Throws std::invalid_argument when there is no cache that
// tasks could share.
FarmJob new_job(Cut cut, const CookRequest& request, const Console& console);

// Makes its folder, empties it of an earlier job but for what that measured, and writes the plan
// there. What an engine cannot take is to be refused before.
void begin_job(FarmJob& job);

// The program and its arguments.
std::vector<std::string> words_of(const FarmJob& job, const FarmTask& task);
// As a shell takes them.
std::string shell_line(const std::vector<std::string>& words);

// The words of a program whose output goes to `file`: a shell sends it there and becomes the
// program.
std::vector<std::string> said_into(const std::filesystem::path& file,
                                   std::vector<std::string> words);

// Compares the files of each shot with its manifest, and what each task says that it made. What is
// wrong is told, a line each, and so are missed expectations. Returns the exit code.
int verify_job(const FarmJob& job, Console& console);

}  // namespace runtime
