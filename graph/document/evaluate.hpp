#pragma once

// A node's parameters at one frame, and how parameters are named in messages.

#include "graph/document/graph.hpp"

namespace graph {

// The node's parameters at a frame: constants, and every curve and expression evaluated. Throws
// Failure when one gives NaN, infinity or a number out of its limits.
ParamValues evaluate(const Node& node, int frame, double time);

// "size", "bricks.damping", "boxes.2.centre": the parameter that `where` leads to.
std::string param_path(const std::vector<Param>& params, const std::vector<std::uint32_t>& where);

// What a parameter takes, for people: "a whole number from 1 to 100".
std::string expectation_of(const Param& param);

// A number for people; NaN without the sign that it may have in memory.
std::string number_text(double x);

// Whether `x` lies within the limits; false for NaN.
inline bool within(double x, const Limits& limits)
{
    return x >= limits.min && x <= limits.max;
}

}  // namespace graph
