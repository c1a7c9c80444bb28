#pragma once

// Meshes that nodes hand on lie at finite places: a node whose parameters or forces make one that
// does not fails there, and not the node that writes it, many steps later.

#include "geometry/mesh/measure.hpp"
#include "graph/types/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace nodes {

// The vertex of a value's mesh that is at no finite place; empty: it has none, or is no mesh.
inline std::string lost_vertex(const graph::Value& value)
{
    if (!value || value.type() != &graph::wire_type<geometry::TriMesh>()) return {};
    return geometry::what_place_is_not_finite(*value.as<geometry::TriMesh>());
}

// What a node makes of a mesh that is not finite need not be so either.
inline bool was_given_lost_vertices(const graph::Call& call)
{
    for (const auto& port : call.inputs) {
        for (const graph::Value& value : port) {
            if (!lost_vertex(value).empty()) return true;
        }
    }
    return false;
}

inline void check_meshes(const graph::Call& call, const std::vector<graph::Value>& outputs)
{
    for (const graph::Value& value : outputs) {
        const std::string lost = lost_vertex(value);
        if (lost.empty() || was_given_lost_vertices(call)) continue;
        throw std::invalid_argument(
            "the mesh that it makes is not finite: " + lost +
            ", where coordinates must stay below 3.4e38 m. Look for too large numbers in its "
            "parameters and in what is linked to it");
    }
}

// For all node types but those that take no mesh and read a file.
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
