#pragma once

// The faces of a mesh of several pieces that lie on the outside of all of them together.

#include "geometry/mesh/mesh_fwd.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <optional>

namespace physics {

// `mesh`, closed, less what of its faces lies within its pieces: who is in one piece just below
// another one's top is nearest to a face that leads deeper in.
//
//      +---------+           +---------+
//      |   +-----|---+       |         +---+     a road on a deck keeps its top and sides, and
//      |   |     |   |  ->   |             |     the deck what the road does not cover
//      +---|-----+   |       +---+         |
//          +---------+           +---------+
//
// Triangles that lie within pieces in part are cut in two along their longest side, down to
// half of `size` (m), or of what cuts all of the mesh into some 25,000. `tree` is of `mesh`.
// None where nothing lies within.
std::optional<geometry::TriMesh> outer_faces(const geometry::TriMesh& mesh,
                                             const geometry::TriangleBvh& tree, double size);

}  // namespace physics
