#pragma once

// Where the flat faces of a mesh end: what a rigid body touches another one with first.

#include "geometry/mesh/mesh_fwd.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace physics {

// Of a triangle, which of its sides (from corner i to the next one) and of its corners lie on a rim
// of a flat face.
struct Rims {
    std::array<bool, 3> side{}, corner{};
};

// Triangles that meet at sides and lie within `off` (m) of one plane are one flat face. Vertices at
// the same place are one vertex. A side that only one triangle has, or more than two, is a rim.
std::vector<Rims> rims_of_flat_faces(const geometry::TriMesh& mesh, double off);

}  // namespace physics
