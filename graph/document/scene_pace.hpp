#pragma once

// How fast time passes in the scene that a node depends on: simulations may take another time a
// frame than the video shows it.

#include "graph/document/graph.hpp"

namespace graph {

// s of the scene that pass in a frame, as the node says it, or else those it depends on; 0 where
// none does, where they disagree, or where it changes with the frame.
double scene_pace(const Graph&, std::uint32_t node);

}  // namespace graph
