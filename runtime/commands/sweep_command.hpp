#pragma once

// `sweep`: cooks every combination of settings; leaves sweep.csv and sweep.png in the output
// folder.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_sweep_command(const CommandSet& set);

struct SweepRequest {
    std::vector<std::string> vary, measures;
    std::string picture;
    int columns = 0;  // of the sheet; 0: as fits
};

int run_sweep(const CookRequest& request, const SweepRequest& wanted,
              const graph::Registry& registry, Console& console);

}  // namespace runtime
