#pragma once

// Commands that read documents or node descriptions and cook nothing, and `study`.

#include "runtime/command_line.hpp"
#include "runtime/cook_command.hpp"
#include "runtime/study.hpp"

namespace CLI {
class App;
}

namespace runtime {

struct StudyRequest {
    std::vector<std::string> vary;
    std::string measure, look, reference;
    double wanted_error = 0.01;
};

// Adds `nodes`, `schema`, `new`, `fmt`, `diff` and `graph`. Each writes its exit code to `exit`.
void add_document_commands(CLI::App& app, CookRequest& request, const graph::Registry& registry,
                           Console& console, int& exit);

// Cooks all that `request` and `wanted` say, and leaves study.csv, study.gp, study.png (where
// gnuplot is installed) and study_sheet.png (the last frame of every trial, where the graph draws
// one) in the output folder.
int run_study(const CookRequest& request, const StudyRequest& wanted,
              const graph::Registry& registry, Console& console);

}  // namespace runtime
