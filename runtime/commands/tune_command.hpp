#pragma once

// `tune`: the coarsest cubes and the longest steps that are within an error, as a table and a
// recommendation.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_tune_command(const CommandSet& set);

struct TuneRequest {
    std::string error = "5%";
    std::vector<std::string> measures;
    std::string size, steps;
    int most = 6;
    double most_cubes = 1e6;
};

int run_tune(const CookRequest& request, const TuneRequest& wanted, const graph::Registry& registry,
             Console& console);

}  // namespace runtime
