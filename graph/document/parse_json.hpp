#pragma once

// From JSON text to a tree in which every value and every key knows where it stands. The library's
// own tree forgets that; its event interface does the parsing, and a scanner of ours keeps in step
// with the events (between two tokens there is only white space, a comma, a colon or a comment).

#include "graph/document/json.hpp"

namespace graph {

struct Comment {
    std::uint32_t begin = 0, end = 0;
};

struct JsonLimits {
    int depth = 64;
    std::size_t values = 4'000'000;
};

// Null when the text is not JSON; what is wrong goes to `problems`, twice-used keys too (the first
// one stays). Comments are as in C++. `origin` must outlive the tree.
std::optional<Json> parse_json(const Origin& origin, const JsonLimits&, Problems& problems,
                               std::vector<Comment>* comments = nullptr);

}  // namespace graph
