#pragma once

// The ports of a subgraph: which inputs, parameters and outputs of the nodes inside the outside
// sees, and handing in what it gives for them.
//
//   "subgraph": { "inputs": { "mesh": { "to": "moved.mesh" } }, ... }      the subgraph's document
//   "fill": { "type": "cubes_in.json", "inputs": { "mesh": "ball" } }      the node outside

#include "graph/document/loading.hpp"

#include <set>

namespace graph {

// A subgraph's node, what is inside, and where to find that by name.
struct PortTargets {
    using Index = std::unordered_map<std::string, std::size_t>;

    const Declaration& outer;
    std::vector<Declaration>& inner;
    const Index& index;
    const Json* declared;  // the member "variables" of its document, or null
    std::map<std::string, double, std::less<>>& variables;  // what the outside gives
    std::set<std::string>& linked;  // inputs that already got a link from outside
};

// Hands what the outer node gives for each promoted input or parameter to the nodes inside. `part`:
// "inputs" or "params", in the outer node and in `face`, the member "subgraph".
void hand_in(Loading& loading, const PortTargets& targets, const Json& face, const char* part);

SubgraphOutputs read_outputs(const Json& face, Problems& problems);

}  // namespace graph
