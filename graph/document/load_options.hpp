#pragma once

// What the caller of the loader may choose: parameters and variables set from outside, which files
// may be read, and how large a document may be.

#include <cstddef>
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

// Variables of a document and their values.
using Variables = std::vector<std::pair<std::string, double>>;

struct LoadOptions {
    // Nothing outside may be read. Empty: project_root() of the document.
    std::filesystem::path root = {};
    bool allow_outside = false;
    std::vector<Override> sets = {};
    Variables variables = {};  // in place of the document's own; of two of a name the later
    std::size_t max_bytes = std::size_t{64} << 20;
    int max_depth = 64;  // of brackets
    int max_frames = 1'000'000;
    std::size_t max_nodes = 1'000'000;  // once subgraphs have taken their places
    // Of so many frames files will be written in one go; 0: all of the document's.
    int written_frames = 0;
    std::string reserved = {};  // a path that no node may write
};

// The nearest folder above the document that holds a folder `graphs` or `.git`, else the document's
// own.
std::filesystem::path project_root(const std::filesystem::path& file);

}  // namespace graph
