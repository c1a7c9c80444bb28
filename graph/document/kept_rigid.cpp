#include "graph/document/kept_rigid.hpp"

#include <algorithm>

namespace graph {

bool kept_rigid(const Graph& graph, std::uint32_t node)
{
    std::vector<char> gives(graph.nodes.size(), 0);
    gives[node] = 1;
    bool rigid = false;
    for (std::size_t n = node + std::size_t{1}; n < gives.size(); ++n) {  // after its inputs
        const Node& reader = graph.nodes[n];
        const NodeType& type = *reader.type;
        for (std::size_t p = 0; p < reader.inputs.size(); ++p) {
            const InputPort& port = type.inputs[p];
            const bool computes = type.bends.link && type.bends.input == port.name;
            const bool hands_on =
                std::any_of(type.outputs.begin(), type.outputs.end(),
                            [&](const OutputPort& out) { return out.type == port.type; });
            for (std::size_t k = 0; k < reader.inputs[p].size(); ++k) {
                if (!gives[reader.inputs[p][k].node]) continue;
                if (computes && type.bends.link(reader.params, k)) return false;
                rigid = rigid || computes;
                gives[n] |= hands_on ? 1 : 0;
            }
        }
    }
    return rigid;
}

}  // namespace graph
