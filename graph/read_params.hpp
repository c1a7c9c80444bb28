#pragma once

// From a node's "params" object in a document to values, curves and expressions.

#include "graph/graph.hpp"
#include "graph/json.hpp"

namespace graph {

// Which files a document may name.
struct PathRules {
    std::filesystem::path root;  // canonical
    bool allow_outside = false;
};

struct ReadContext {
    const FrameRange& range;
    const PathRules& paths;
    Problems& problems;
};

// Fills node.params and node.animated from `given` (null: all defaults). Wants node.name and
// node.type. Parameters that were not given, or that are wrong, keep their defaults.
void read_params(const Json* given, const ReadContext&, Node& node);

// The number that a constant or an expression without frame and time stands for; null after
// reporting into `problem` (of which only message, expected, found, suggestion and place are set).
std::optional<double> read_constant(const Json&, Problem& problem);

// Whether a file may have such a name: one with control characters is none that a person gave, and
// would break lines where names are listed.
bool can_be_a_path(std::string_view text);

// Whether `path` is `root` or below it; both lexically normal and absolute.
bool lies_in(const std::filesystem::path& path, const std::filesystem::path& root);

// The name of a file of `folder` that `name` may be a slip of; or a list of a few that there are.
std::string suggest_file(const std::filesystem::path& path);

}  // namespace graph
