#pragma once

// Bodies that stay apart wherever they lie: which faces of a mesh are of which, and the cubes of
// all in one grid, where those of several may share a cell but never a corner.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

struct FaceBodies {
    std::vector<std::uint32_t> of;  // F, by order of first faces; no_index: not finite
    std::size_t count = 0;
};

// Each piece of the mesh (mesh/pieces.hpp) is a body. A closed piece that is wound against the
// solid around it bounds a hollow: it is of the body of the smallest piece around it.
FaceBodies bodies_of_pieces(const TriMesh& mesh);

// The same, where pieces that have faces of one group are one body.
FaceBodies bodies_of_groups(const TriMesh& mesh);

// All cubes in one grid, sorted; those of the first bodies come first in a cell. They are of one
// size and origin, and have the same matters and attributes. Of two bodies and more, all have a
// `part` (Cubes): a body that has none fills its cells.
Cubes side_by_side(std::span<const Cubes> bodies);

}  // namespace geometry
