#pragma once

// Numbers that do not change with the frame: written as such, or as expressions without frame and
// time.

#include "graph/document/expression.hpp"
#include "graph/document/json.hpp"
#include "graph/document/problem.hpp"

#include <optional>
#include <string>

namespace graph {

// Whether it is a text that begins with '='.
bool is_expression(const Json& json);

// Null after reporting into `problem`, its place included.
std::optional<Expression> compile_expression(const Json& json, Problem& problem);

// The number that a constant or an expression without frame and time stands for; null after
// reporting into `problem` (of which only message, expected, found, suggestion and place are set).
std::optional<double> read_constant(const Json& json, Problem& problem);

// A number or constant expression; null after a report.
std::optional<double> read_number(const Json& json, const std::string& expected,
                                  Problems& problems);

// A whole number that a frame may have; null after a report.
std::optional<int> read_frame(const Json& json, Problems& problems);

}  // namespace graph
