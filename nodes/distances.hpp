#pragma once

// Distances between two values of a wire type. `aspic study` measures errors with them: how far a
// result is from a reference. A wire type without a function here cannot be compared.

#include "geometry/mesh/measure.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <functional>
#include <map>
#include <stdexcept>

namespace nodes {

// Root mean square of the distances between vertices with the same index. Throws
// std::invalid_argument if the numbers of vertices differ.
inline double mesh_distance(const geometry::TriMesh& a, const geometry::TriMesh& b)
{
    if (a.positions.size() != b.positions.size()) {
        throw std::invalid_argument(fmt::format(
            "the mesh has {} vertices, the reference has {}: vary parameters that do not change "
            "the number of vertices, or compare a number (from a Measure node). If the mesh tears, "
            "set torn = hide or stretch in Embed, because cutting adds vertices",
            a.positions.size(), b.positions.size()));
    }
    return geometry::displacement(a, b).rms;
}

// The functions above by the name of the wire type.
inline std::map<std::string, std::function<double(const graph::Value&, const graph::Value&)>>
distances()
{
    return {{"mesh", [](const graph::Value& a, const graph::Value& b) {
                 return mesh_distance(*a.as<geometry::TriMesh>(), *b.as<geometry::TriMesh>());
             }}};
}

}  // namespace nodes
