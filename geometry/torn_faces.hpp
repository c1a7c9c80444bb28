#pragma once

#include "geometry/clip_to_cells.hpp"
#include "geometry/cubes.hpp"
#include "geometry/mesh.hpp"

#include <span>

namespace geometry {

// Which faces of a mesh at rest pass through cubes that have lost a link between two corners. Links
// are named 3 * corner + axis, ascending, by the lower of their corners. F. Pieces of the mesh that
// share cells with cubes of another component count as well.
std::vector<std::uint8_t> torn_faces(const TriMesh& rest, const Cubes& cubes,
                                     std::span<const std::uint32_t> broken);

// What these cells fill, in lattice coordinates.
Box bounds_of(std::span<const Vec3i> cells);

// Those that pass through some of these cells, which are in the order of cubes. F.
std::vector<std::uint8_t> faces_through(const TriMesh& rest, const Cubes& cubes,
                                        std::span<const Vec3i> cells);

// A face of a mesh at rest in lattice coordinates. On a plane, whose axis without extent is `flat`,
// it may lie above it or below, and counts as if in it.
Polygon lattice_face(const TriMesh& rest, const Cubes& cubes, std::size_t face, int flat);

// The order of cubes, by their cells.
bool in_front(const Vec3i& a, const Vec3i& b);

// The mesh without the faces that are named (F). Vertices and all that belongs to them stay.
TriMesh without_faces(TriMesh mesh, const std::vector<std::uint8_t>& gone);

}  // namespace geometry
