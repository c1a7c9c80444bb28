#pragma once

// What lines along the axes meet in single cells: how much of each is inside, and through which
// winding numbers the lines run there.

#include "geometry/cells/cell_votes.hpp"

namespace geometry {

// What lines along the axes meet in cells, four by four of them through each.
struct CellLines {
    // Which of the 4 x 4 x 4 points where they cross are inside: bit x + 4 y + 16 z.
    std::vector<std::uint64_t> inside;
    // The winding numbers they run through in a cell, for longer than a thousandth of it: bits of
    // WindingBit.
    std::vector<std::uint8_t> windings;
};

// Lines along all axes, that of six rays more than half decide. `cells` sorted by (z, y, x).
CellLines cell_lines(const LatticeMesh& mesh, Inside rule, std::span<const Vec3i> cells);

// Lines along one axis, its two rays must agree: the same on a closed mesh.
CellLines cell_lines_along(int axis, const LatticeMesh& mesh, Inside rule,
                           std::span<const Vec3i> cells);

}  // namespace geometry
