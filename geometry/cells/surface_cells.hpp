#pragma once

// Which cells the surface of a mesh passes through.

#include "geometry/cells/cell_set.hpp"
#include "geometry/cells/voxel_grid.hpp"

namespace geometry {

// What counts as a triangle meeting a cube.
enum class CellShape {
    // The triangle meets the cube less its upper faces. Cells then share out space, each point has
    // one, so every cell that holds a point of a triangle is there. (Where a triangle meets a cube
    // in one corner or in points of one edge only, it may be counted although all that it meets
    // is on an upper face.)
    half_open,
    // The triangle meets the cube's inside. One that lies in a face meets neither neighbour.
    interior,
};

// The cells that triangles meet, exactly but for rounding in double precision: no cell that a
// triangle crosses is left out, none is there that it passes by. Triangles without area count as
// the segments or points that they are. Throws TooManyCells above `limit`.
CellSet surface_cells(const LatticeMesh& mesh, CellShape shape,
                      std::size_t limit = ~std::size_t{0});

}  // namespace geometry
