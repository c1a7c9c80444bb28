#pragma once

// Objects of one file that touch: welding made one piece of them.

#include "geometry/mesh/mesh_fwd.hpp"

#include <cstddef>

namespace geometry {

struct WeldedGroups {
    std::size_t groups = 0;  // closed ones that share a piece with another closed one
    std::size_t pieces = 0;  // which they are
};

// A group counts where each of its edges, within a piece, is passed as often in one direction as in
// the other. Parts of one surface, such as the side and the ends of a cylinder, do not.
WeldedGroups find_welded_groups(const TriMesh& mesh);

}  // namespace geometry
