#pragma once

// Meshes that nodes hand on lie at finite places: a node whose parameters or forces make one that
// does not fails there, and not the node that writes it, many steps later.

#include "geometry/mesh/mesh.hpp"
#include "graph/types/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace nodes {

// The number of the first vertex at no finite place; none: as many as there are.
inline std::size_t first_lost(const geometry::TriMesh& mesh)
{
    const auto& places = mesh.positions;
    const auto found =
        std::find_if(places.begin(), places.end(), [](const auto& p) { return !p.allFinite(); });
    return static_cast<std::size_t>(found - places.begin());
}

// What a node makes of a mesh that is not finite need not be so either.
inline bool was_given_others(const graph::Call& call)
{
    for (const auto& port : call.inputs) {
        for (const graph::Value& value : port) {
            if (!value || value.type() != &graph::wire_type<geometry::TriMesh>()) continue;
            const auto mesh = value.as<geometry::TriMesh>();
            if (first_lost(*mesh) < mesh->positions.size()) return true;
        }
    }
    return false;
}

inline void check_meshes(const graph::Call& call, const std::vector<graph::Value>& outputs)
{
    for (const graph::Value& value : outputs) {
        if (!value || value.type() != &graph::wire_type<geometry::TriMesh>()) continue;
        const auto mesh = value.as<geometry::TriMesh>();
        const std::size_t lost = first_lost(*mesh);
        if (lost == mesh->positions.size() || was_given_others(call)) continue;
        const auto& p = mesh->positions[lost];
        throw std::invalid_argument(fmt::format(
            "the mesh that it makes is not finite: vertex {} is at ({:g}, {:g}, {:g}), where "
            "coordinates must stay below 3.4e38 m. Look for too large numbers in its parameters "
            "and "
            "in what is linked to it",
            lost + 1, p.x(), p.y(), p.z()));
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
