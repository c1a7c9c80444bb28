#pragma once

// How far apart two values of a wire type are, for studies of speed against error.

#include "geometry/measure.hpp"
#include "nodes/wire_types.hpp"

#include <functional>
#include <map>

namespace nodes {

// By name of wire type. Meshes: root mean square of the distances between vertices of one number.
inline std::map<std::string, std::function<double(const graph::Value&, const graph::Value&)>>
distances()
{
    return {{"mesh", [](const graph::Value& a, const graph::Value& b) {
                 return geometry::displacement(*a.as<geometry::TriMesh>(),
                                               *b.as<geometry::TriMesh>())
                     .rms;
             }}};
}

}  // namespace nodes
