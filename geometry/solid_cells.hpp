#pragma once

#include "geometry/cell_set.hpp"
#include "geometry/voxel_grid.hpp"

namespace geometry {

// When a point is inside a mesh. Six rays go out from it, one each way along the axes; each counts
// what it crosses and casts a vote; a point is inside when more than half of the six say so.
// On a closed mesh all rays agree and the rule is exact. Where a mesh is open, those rays that
// leave through the hole are outvoted as long as it is no larger than most of the rays' view.
enum class Inside {
    // A ray adds 1 where it leaves and takes 1 where it enters, by the faces' orientation, and
    // votes by the sign of the sum. Right for pieces that overlap, for faces named several times
    // and for pieces turned inside out as a whole; a piece turned inside out within another one is
    // a cavity. Wrong where neighbouring faces disagree on what is outside.
    winding,
    // A ray votes inside when it crosses an odd number of faces. Needs no orientation; parts
    // where two pieces overlap count as outside.
    parity,
};

// The cells of a solid: those whose inside a triangle crosses, and those whose centre is inside.
// A triangle that lies in a face between cells adds the upper one where neither of the two is
// there otherwise, so that a sheet is not lost. Throws TooManyCells above `limit`.
CellSet solid_cells(const LatticeMesh& mesh, Inside rule, std::size_t limit = ~std::size_t{0});

// What lines along the axes meet in cells, four by four of them through each.
struct CellLines {
    // Which of the 4 x 4 x 4 points where they cross are inside: bit x + 4 y + 16 z.
    std::vector<std::uint64_t> inside;
    // The winding numbers they run through in a cell, for longer than a thousandth of it.
    std::vector<std::uint8_t> windings;
    enum : std::uint8_t { plus_one = 1, minus_one = 2, beyond = 4 };
};

// Lines along all axes, that of six rays more than half decide. `cells` sorted by (z, y, x).
CellLines cell_lines(const LatticeMesh& mesh, Inside rule, std::span<const Vec3i> cells);

// Lines along one axis, its two rays must agree: the same on a closed mesh.
CellLines cell_lines_along(int axis, const LatticeMesh& mesh, Inside rule,
                           std::span<const Vec3i> cells);

}  // namespace geometry
