#pragma once

// Nodes whose type is a document: "type": "assets/jelly.json@2". Each is replaced by the nodes
// inside of that document, called "outer/inner".

#include "graph/document/loading.hpp"

namespace graph {

// Moves nodes to Loading::declarations, each subgraph as what is in it. `chain`: the files that led
// here.
void expand_subgraphs(Loading& loading, std::vector<Declaration> nodes,
                      const std::vector<std::filesystem::path>& chain);

}  // namespace graph
