#pragma once

// How far apart two values of a wire type are, for studies of speed against error.

#include "geometry/measure.hpp"
#include "nodes/wire_types.hpp"

#include <functional>
#include <map>
#include <stdexcept>

namespace nodes {

// Root mean square of the distances between vertices of one number. Throws std::invalid_argument
// when there are not as many.
inline double mesh_distance(const geometry::TriMesh& a, const geometry::TriMesh& b)
{
    if (a.positions.size() != b.positions.size()) {
        throw std::invalid_argument(
            "its mesh has " + std::to_string(a.positions.size()) + " vertices, the reference's " +
            std::to_string(b.positions.size()) +
            ": vary what keeps them, or compare a number (put a Measure node behind the mesh); if "
            "it is torn, let Embed hide or stretch that (torn: hide), as cutting it adds vertices");
    }
    return geometry::displacement(a, b).rms;
}

// By name of wire type.
inline std::map<std::string, std::function<double(const graph::Value&, const graph::Value&)>>
distances()
{
    return {{"mesh", [](const graph::Value& a, const graph::Value& b) {
                 return mesh_distance(*a.as<geometry::TriMesh>(), *b.as<geometry::TriMesh>());
             }}};
}

}  // namespace nodes
