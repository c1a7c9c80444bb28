#pragma once

// Cubes for bodies whose parts come nearer to each other than a cube: a cube for each piece of
// material in a cell, joined to those of the neighbouring cells across what material crosses.
// Nesme, Kry, Jerabkova, Faure. Preserving topology and elasticity for embedded deformable models.
// ACM TOG 28(3), 2009.

#include "geometry/cells/held_cells.hpp"
#include "geometry/cubes/cubes.hpp"

namespace geometry {

// A cube for each piece in each cell: quarters that links join within the cell. Cubes of
// neighbouring cells share the corners that their cells have in common, four across a face, where
// a link leads from one piece to the other. Copies of a cell are sorted by their first quarter.
// Where every cell has one piece and all neighbours share their corners, the result is that of
// number_corners(), and `part` stays empty.
// `join`, in m, 0 or more: pieces of one cell whose quarters come as near are one, and those of
// neighbouring cells share their corners as if a link led from one to the other. Quarters are
// nearer than what they hold: pieces within `join` of each other are joined, and some that are up
// to half a cube farther apart along an axis.
Cubes cubes_of_pieces(const HeldCells& cells, double size, const Vec3& origin, double join = 0);

}  // namespace geometry
