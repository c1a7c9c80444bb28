#pragma once

// Graphs compared by meaning, and nodes and graphs as text.

#include "graph/document/graph.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace graph {

// How graph `b` differs from `a` in meaning, a line each in order of name; empty when they cook the
// same. Order, comments, notation ("=0.5 * 2" for 1), defaults written out and subgraphs written
// out make no difference.
//   frames: 1 to 48 at 24 fps -> 1 to 12 at 24 fps
//   - scale (Weigh@1)
//   ~ knead.time: 5 -> 14
//   ~ knead <- dough: mill.dough -> mixer.dough
std::vector<std::string> difference(const Graph& a, const Graph& b);

// ---- a node as text, for comparison and for people

using Texts = std::map<std::string, std::string>;
// Every plain value of a node by its path: "gas.burners", "boxes.0.height". What moves is the text
// of its expression or keyframes.
Texts values_of(const Node& node);
// What each input is linked to: "mill.dough, mixer.dough", or "nothing".
Texts links_of(const Graph& graph, const Node& node);
// The files that a node's parameters name, by the same paths.
std::map<std::string, std::filesystem::path> files_of(const Node& node);

// Those of sequences, a file a frame, at this one; without what is not there.
std::vector<std::filesystem::path> files_at(const Node& node, int frame);

// The graph for Graphviz: `dot -Tsvg`.
std::string dot_text(const Graph& graph);

}  // namespace graph
