#pragma once

// Whether a body that a node makes keeps its shape in all that computes with it.

#include "graph/document/graph.hpp"

namespace graph {

// Of what the node gives, straight or by nodes that hand on the same kind of thing: whether some
// node keeps it rigid, and none may bend it (NodeType::bends). What only draws or measures it says
// nothing.
bool kept_rigid(const Graph&, std::uint32_t node);

}  // namespace graph
