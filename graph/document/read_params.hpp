#pragma once

// From a node's "params" object in a document to values, curves and expressions.

#include "graph/document/param_reading.hpp"

namespace graph {

// Fills node.params and node.animated from `given` (null: all defaults). Wants node.name and
// node.type. Parameters that were not given, or that are wrong, keep their defaults.
void read_params(const Json* given, const ReadContext&, Node& node);

}  // namespace graph
