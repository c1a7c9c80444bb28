#pragma once

// Which cells a solid fills.

#include "geometry/cells/cell_set.hpp"
#include "geometry/cells/inside.hpp"
#include "geometry/cells/voxel_grid.hpp"

namespace geometry {

// The cells of a solid: those whose inside a triangle crosses, and those whose centre is inside.
// A triangle that lies in a face between cells adds the upper one where neither of the two is
// there otherwise, so that a sheet is not lost. Throws TooManyCells above `limit`.
CellSet solid_cells(const LatticeMesh& mesh, Inside rule, std::size_t limit = ~std::size_t{0});

}  // namespace geometry
