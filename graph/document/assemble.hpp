#pragma once

// From files to one flat list of nodes: shot files laid over the documents that they extend,
// subgraph files put in place of the nodes that name them, parameters set from outside.

#include "graph/document/loading.hpp"

namespace graph {

// Fills Loading up to its declarations, and the graph's range and documents, from the text of
// `file`.
void assemble(Loading& loading, std::string text, const std::filesystem::path& file);

}  // namespace graph
