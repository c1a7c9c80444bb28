#pragma once

// Reads a graph document (docs/file-format.md) and checks everything that can be checked before a
// frame is cooked. All mistakes of a file are found in one go.

#include "graph/graph.hpp"
#include "graph/problem.hpp"

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace graph {

// "cubes.size=0.02": a parameter set from outside the document. Blocks and list elements are
// reached through more dots: "sim.bricks.damping", "ground.boxes.0.height". The value is JSON, or
// a bare word, which is a text.
struct Override {
    std::string target;  // "cubes.size"
    std::string value;   // "0.02"
};

// Throws std::invalid_argument unless `text` reads node.parameter=value.
Override parse_override(std::string_view text);

struct LoadOptions {
    // Nothing outside may be read. Empty: the nearest folder above the document that holds a
    // folder `graphs` or `.git`, else the document's own.
    std::filesystem::path root = {};
    bool allow_outside = false;
    std::vector<Override> sets = {};
    std::vector<std::pair<std::string, double>> variables = {};  // in place of the document's own
    std::size_t max_bytes = std::size_t{64} << 20;
    int max_depth = 64;  // of brackets
    int max_frames = 1'000'000;
    std::size_t max_nodes = 1'000'000;  // once subgraphs have taken their places
};

struct Loaded {
    Graph graph;  // empty when there are errors
    std::vector<Problem> problems;

    bool ok() const { return !has_errors(problems); }
};

// `registry` must outlive the graph. Never throws for what a document or file system may hold.
Loaded load_file(const std::filesystem::path& file, const Registry& registry,
                 const LoadOptions& options = {});

// The same from memory; `file` names it in messages, and relative paths start at its folder.
Loaded load_text(std::string text, const std::filesystem::path& file, const Registry& registry,
                 const LoadOptions& options = {});

// The project's root for a document, as LoadOptions::root tells.
std::filesystem::path project_root(const std::filesystem::path& file);

}  // namespace graph
