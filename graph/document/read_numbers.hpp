#pragma once

// Parameters that are numbers, vectors or colours: plain, by an expression, or by keyframes. What
// moves becomes an entry of Node::animated.

#include "graph/document/param_reading.hpp"

namespace graph {

// The value, or the default where it moves or after a report.
ParamValue read_number_param(const ParamReading& reading, const Param& param, const Json& json);

// Three numbers as a list, a colour's name, or keyframes of these; each number of a list may be an
// expression or a curve.
ParamValue read_vector_param(const ParamReading& reading, const Param& param, const Json& json);

}  // namespace graph
