#pragma once

// Keeps a cook from writing over the files that it is made from: a mesh that it reads, or its own
// document.

#include "graph/document/graph.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace runtime {

// Throws std::invalid_argument where a cook of `nodes` at `frames` would write a file into `folder`
// that is one of the graph's documents or that a node of this cook reads. Files that files name in
// turn, as textures, are not known yet.
void require_sources_stay(const graph::Graph& graph, const std::filesystem::path& folder,
                          const std::vector<std::uint32_t>& nodes, const std::vector<int>& frames);

}  // namespace runtime
