#pragma once

// Links: which output each input takes. A link is "node.output", or "node" when that node has one
// output; an output of a subgraph stands for one of a node inside.

#include "graph/document/loading.hpp"

namespace graph {

// Fills the inputs of all nodes, and reports those that must be linked and are not.
void link_nodes(Loading& loading);

// The output that `json` names; null after a report for input `port` of node `name`, which takes
// wires of type `type`; empty: of any.
std::optional<Link> find_link(Loading& loading, const Json& json, const std::string& type,
                              const std::string& name, const std::string& port);

// Puts nodes into the order in which they cook, or reports the loops that their links form.
void sort_or_report_loops(Loading& loading);

}  // namespace graph
