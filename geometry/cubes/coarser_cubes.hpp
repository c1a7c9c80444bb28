#pragma once

// Which cube of a coarser grid a cube lies in.

#include "geometry/cubes/cubes.hpp"

namespace geometry {

// For each cube of `fine` the one of `coarse` that it lies in, or no_index where that cell is
// empty. `ratio` fine cubes lie along the edge of a coarse one; both grids start at one origin.
// Where several cubes share a cell (Cubes::part), it is the one that shares most quarters of the
// cell with the material of the fine cube; where none does, the nearest.
std::vector<std::uint32_t> coarser_cubes(const Cubes& coarse, const Cubes& fine, int ratio);

}  // namespace geometry
