#pragma once

// How many nodes a document stands for once its subgraphs are expanded. Each file is parsed once
// for it, however often and however deep it is used: 17 small files may stand for 2^64 nodes.

#include "graph/document/loading.hpp"

namespace graph {

// False, after a report, when `nodes` stand for more nodes than LoadOptions::max_nodes. Those that
// stand for documents count too. What is wrong in the documents is told by expand_subgraphs().
bool few_enough(Loading& loading, const std::vector<Declaration>& nodes,
                const std::vector<std::filesystem::path>& chain);

}  // namespace graph
