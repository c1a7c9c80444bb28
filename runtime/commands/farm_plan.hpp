#pragma once

// What `farm` was asked for, cut into tasks, and how that is shown before it is sent.

#include "runtime/commands/cook_request.hpp"
#include "runtime/farm/cut.hpp"

#include <array>

namespace runtime {

// That a plan tells the time of.
inline constexpr std::array machine_counts{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000};

struct FarmRequest {
    std::string engine;               // local, slurm or openjd; empty: none was named
    bool plan = false;                // show, and send nothing
    std::string svg;                  // with `plan`: the file that it is drawn into
    std::vector<std::string> vary;    // settings, each combination a shot
    double task_seconds = 30;         // s of work of a task that can be cut anywhere
    int machines = 0;                 // local: tasks at once; 0: as many as the cores allow
    bool wait = false;                // slurm: until all is done
    std::vector<std::string> sbatch;  // slurm: further options of each job
};

// Loads and cuts all files and settings. Nothing when a document has errors, which were told.
std::optional<Cut> plan_farm(const CookRequest& request, const FarmRequest& farm,
                             const graph::Registry& registry, Console& console);

// A line for each shot and kind of task, the longest path, and the time on so many machines.
std::string plan_text(const Cut& cut);
// At most that many bytes, whole characters of UTF-8, and "..." where some are left out.
std::string shortened(std::string text, std::size_t most);

std::string plan_json(const Cut& cut);
// Back from JSON. Throws nlohmann::json::exception when it is no plan.
Cut cut_from(const std::string& json);

}  // namespace runtime
