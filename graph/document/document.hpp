#pragma once

// Reads a graph document (docs/file-format.md) and checks everything that can be checked before a
// frame is cooked. All mistakes of a file are found in one go. loading.hpp shows the steps.

#include "graph/document/graph.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/problem.hpp"
#include "graph/types/registry.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace graph {

struct Loaded {
    Graph graph;  // empty when there are errors
    std::vector<Problem> problems;

    Variables variables;  // of the document; empty when there are errors

    bool ok() const { return !has_errors(problems); }
};

// `registry` must outlive the graph. Never throws for what a document or file system may hold.
Loaded load_file(const std::filesystem::path& file, const Registry& registry,
                 const LoadOptions& options = {});

// The same from memory; `file` names it in messages, and relative paths start at its folder.
Loaded load_text(std::string text, const std::filesystem::path& file, const Registry& registry,
                 const LoadOptions& options = {});

}  // namespace graph
