#pragma once

// Cuts the cook of one graph where it must be cut. What differs from frame to frame and remembers
// nothing is cut anywhere; simulations are not, nor what a simulation needs of itself through other
// nodes: simulations of which one depends on another are one chain, and step side by side.

#include "graph/document/graph.hpp"
#include "runtime/farm/farm_task.hpp"
#include "runtime/farm/node_costs.hpp"

#include <vector>

namespace runtime {

// What is asked of one graph. Its keys are aimed at `targets` and `frames`.
struct Asked {
    const graph::Graph& graph;
    Keys& keys;
    const std::vector<std::uint32_t>& targets;
    const std::vector<int>& frames;  // ascending
    const Stored& stored;
    const NodeCosts& costs;
    double task_seconds;  // a task of the stage `frames` is worth that much
};

// A frame of a chain.
struct ChainStep {
    Key made;              // chains with one `made` are the same up to this frame
    double seconds = 0;    // what is left, frames since the last one that is asked for included
    bool missing = false;  // something is
};

// A task of one graph, before it is known what graphs share.
struct Piece {
    Stage stage = Stage::frames;
    std::vector<std::string> nodes;
    std::vector<int> frames;
    std::vector<std::uint32_t> after;  // pieces before it
    double seconds = 0;
    std::vector<ChainStep> steps;  // of a chain: by place in `frames`
    Key same = {};  // other pieces of one `same` make the same; zero: that is not known
};

// A node that is the same at all frames.
struct Still {
    std::string node;
    Key key;
    double seconds = 0;                 // of itself
    bool held = false;                  // in the cache
    bool used = false;                  // by what differs from frame to frame
    std::vector<std::uint32_t> inputs;  // into GraphPieces::still
};

struct GraphPieces {
    std::vector<Piece>
        pieces;  // each after those that it waits for; the last stage is not among them
    std::vector<Still> still;  // inputs first
    double last_seconds = 0;   // of what only the whole cook can make
    std::size_t results = 0, held = 0;
};

GraphPieces cut_graph(const Asked& asked);

}  // namespace runtime
