#pragma once

// From declarations to nodes: each finds its type, is brought up to the type's version, and reads
// its parameters. links.hpp does the inputs.

#include "graph/document/loading.hpp"

namespace graph {

// Fills the nodes of Loading::graph, one per declaration; the type of a wrong one stays null.
void make_nodes(Loading& loading);

}  // namespace graph
