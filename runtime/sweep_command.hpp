#pragma once

#include "runtime/cook_command.hpp"

namespace runtime {

struct SweepRequest {
    std::vector<std::string> vary, measures;
    std::string picture;
    int columns = 0;  // of the sheet; 0: as fits
};

// Cooks all combinations and leaves sweep.csv and sweep.png in the output folder.
int run_sweep(const CookRequest& request, const SweepRequest& wanted,
              const graph::Registry& registry, Console& console);

}  // namespace runtime
