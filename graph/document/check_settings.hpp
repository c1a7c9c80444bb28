#pragma once

// Finds before a cook what every cook would fail at: what node types say of their own parameters
// and links (NodeType::check), and files that two nodes would write over each other.

#include "graph/document/loading.hpp"

namespace graph {

// After link_nodes(), before the nodes are sorted. Nodes with errors are passed over.
void check_settings(Loading& loading);

}  // namespace graph
