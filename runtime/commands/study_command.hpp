#pragma once

// `study`: leaves study.csv, study.gp, study.png (where gnuplot is installed) and study_sheet.png
// (the last frame of every trial, where the graph draws one) in the output folder.

#include "runtime/commands/command_options.hpp"

namespace runtime {

struct StudyRequest {
    std::vector<std::string> vary;
    std::vector<std::string> measures;
    std::string look, reference;
    double wanted_error = 0.01;
};

void add_study_command(const CommandSet& set);

int run_study(const CookRequest& request, const StudyRequest& wanted,
              const graph::Registry& registry, Console& console);

}  // namespace runtime
