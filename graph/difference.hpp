#pragma once

#include "graph/graph.hpp"

#include <string>
#include <vector>

namespace graph {

// How graph `b` differs from `a` in meaning, a line each in order of name; empty when they cook the
// same. Order, comments, notation ("=0.5 * 2" for 1), defaults written out and subgraphs written
// out make no difference.
//   frames: 1 to 48 at 24 a second -> 1 to 12 at 24 a second
//   - scale (Weigh@1)
//   ~ knead.time: 5 -> 14
//   ~ knead <- dough: mill.dough -> mixer.dough
std::vector<std::string> difference(const Graph& a, const Graph& b);

// The graph for Graphviz: `dot -Tsvg`.
std::string dot_text(const Graph& graph);

}  // namespace graph
