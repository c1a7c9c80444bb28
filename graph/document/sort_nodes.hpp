#pragma once

// The order in which nodes cook.

#include "graph/document/graph.hpp"

namespace graph {

// Reorders nodes so that each stands after those it takes inputs from, adapting all links. The
// order depends on names and links only, not on where a node stood in its document. Returns the
// cycles found, each as the list of its nodes (then the order is left as it was).
std::vector<std::vector<std::uint32_t>> sort_nodes(Graph& graph);

}  // namespace graph
