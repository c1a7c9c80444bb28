#pragma once

#include "geometry/cubes.hpp"
#include "geometry/mesh.hpp"

#include <span>

namespace geometry {

// Which faces of a mesh at rest pass through cubes that have lost a link between two corners. Links
// are named 3 * corner + axis, ascending, by the lower of their corners. F. Pieces of the mesh that
// share cells with cubes of another component count as well.
std::vector<std::uint8_t> torn_faces(const TriMesh& rest, const Cubes& cubes,
                                     std::span<const std::uint32_t> broken);

// The mesh without the faces that are named (F). Vertices and all that belongs to them stay.
TriMesh without_faces(TriMesh mesh, const std::vector<std::uint8_t>& gone);

}  // namespace geometry
