#pragma once

// Meshes that nodes hand on are finite: a node whose parameters or forces make one that is not
// fails there, and not the node that writes it, many steps later.

#include "geometry/mesh/measure.hpp"
#include "graph/types/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace nodes {

// Files hold what they hold, and what a node makes of a mesh with holes in its numbers has them
// too.
inline bool was_given_others(const graph::Call& call)
{
    for (const auto& port : call.inputs) {
        for (const graph::Value& value : port) {
            if (!value || value.type() != &graph::wire_type<geometry::TriMesh>()) continue;
            if (!geometry::all_finite(*value.as<geometry::TriMesh>())) return true;
        }
    }
    return false;
}

inline void check_meshes(const graph::Call& call, const std::vector<graph::Value>& outputs)
{
    for (const graph::Value& value : outputs) {
        if (!value || value.type() != &graph::wire_type<geometry::TriMesh>()) continue;
        const auto what = geometry::what_is_not_finite(*value.as<geometry::TriMesh>());
        if (what.empty() || was_given_others(call)) continue;
        throw std::invalid_argument("the mesh that it makes is not finite: " + what +
                                    " (coordinates must stay below 3.4e38 m). Use smaller numbers "
                                    "in its parameters");
    }
}

// For all node types but those that read meshes from files.
inline void keep_meshes_finite(graph::NodeType& type)
{
    const auto takes_or_makes = [](const auto& ports) {
        return std::any_of(ports.begin(), ports.end(), [](auto& p) { return p.type == "mesh"; });
    };
    const auto reads_file = [](const graph::Param& p) {
        return p.kind == graph::ParamKind::path_in;
    };
    const bool reads = std::any_of(type.params.begin(), type.params.end(), reads_file);
    if (!takes_or_makes(type.outputs) || (reads && !takes_or_makes(type.inputs))) return;
    type.run = [run = std::move(type.run)](const graph::Call& call) {
        auto outputs = run(call);
        check_meshes(call, outputs);
        return outputs;
    };
}

}  // namespace nodes
