#pragma once

// Whether a file says anything of a material. Where it does not, vertices show their own colours if
// they have any, as scans and painted meshes do.

#include "geometry/mesh/mesh.hpp"

namespace geometry {

// What a file without materials gives, or assimp for it: unnamed, and of Material's own grey or
// (glTF, STL) white.
inline bool is_unstated(const Material& m)
{
    if (m.texture || (!m.name.empty() && m.name != "DefaultMaterial")) return false;
    return (m.colour - Material{}.colour).norm() < 0.01f || m.colour == Vec3f(1, 1, 1);
}

inline bool has_vertex_colours(const TriMesh& mesh)
{
    return !mesh.colours.empty() && mesh.colours.size() == mesh.positions.size();
}

}  // namespace geometry
