#pragma once

// Which separate pieces of a mesh the cubes glue together.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/pieces.hpp"

namespace geometry {

// Pieces that share corners of cubes although they neither touch nor overlap, nor are joined by
// pieces that do.
struct GluedPieces {
    std::size_t count = 0;                // of pieces; 0: none
    bool at_least = false;                // there are more pairs than it looks at
    std::array<std::uint32_t, 2> pair{};  // the two that are nearest
    Vec3 where = Vec3::Zero();            // m, between them
    double gap = 0;                       // m, between these
    double size = 0;                      // m, the largest cubes that keep these apart
};

// Pieces within `join` (m) of each other are joined on purpose: they count as touching.
// Distances are those from points of the surface, half a cube apart, to the other piece.
// Looks at the first 256 pairs, and at 256 points of each piece of a pair.
GluedPieces find_glued_pieces(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes,
                              double join = 0);

}  // namespace geometry
