#pragma once

// A graph that was loaded and found right: what the runtime cooks. Made by load() in document.hpp
// (or by hand in a test); nothing in it can be wrong any more except values that only a frame
// decides.

#include "graph/document/problem.hpp"
#include "graph/types/node_type.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace graph {

struct Link {
    std::uint32_t node = 0;    // into Graph::nodes
    std::uint32_t output = 0;  // into that node's type's outputs
};

// A number that a keyframe curve or an expression gives anew each frame, or a file a frame.
struct Animated {
    std::vector<std::uint32_t> where;    // indices down the nested ParamValues to the parameter
    int component = -1;                  // 0..2 of a vector or colour, -1 for a plain number
    ParamKind kind = ParamKind::number;  // integer: rounded to nearest
    Limits limits;                       // checked at each frame
    std::function<double(int frame, double time)> value;
    std::function<std::filesystem::path(int frame)> file;  // of kind path_in: throws what is wrong
    std::string source;                                    // its canonical text, for people
    Place place;
};

struct Node {
    std::string name;
    const NodeType* type = nullptr;
    std::vector<std::vector<Link>> inputs;  // per input port
    ParamValues params;                     // constants in place; animated ones hold anything
    std::vector<Animated> animated;
    Place place;
};

// What an input of the node is linked to.
inline std::span<const Link> links_to(const Node& node, std::string_view input)
{
    for (std::size_t i = 0; i < node.type->inputs.size(); ++i) {
        if (node.type->inputs[i].name == input) return node.inputs[i];
    }
    return {};
}

// What a scene promises of a number on a wire; see docs/file-format.md, "expect".
struct Expectation {
    Link value;
    std::vector<int> frames;  // at each of these
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    std::string why;
    Place place;
};

struct Graph {
    std::string file;                              // the document it came from, for messages
    std::vector<std::filesystem::path> documents;  // all that it was read from, that one first
    std::filesystem::path root;                    // nothing outside may be read
    FrameRange range;
    std::vector<Node> nodes;  // sorted: every node stands after those it takes inputs from
    std::vector<Expectation> expectations;
};

}  // namespace graph
