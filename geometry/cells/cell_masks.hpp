#pragma once

// Which cells small triangles meet, several triangles at a time: the inner loop of
// surface_cells.cpp.

#include "geometry/base/vec.hpp"

namespace geometry {

// Triangles that reach over at most 8 x 8 x 8 cells, side by side, and the cells that each meets.
struct SmallTriangles {
    static constexpr int reach = 8;
    static constexpr std::size_t most = 64;

    std::size_t count = 0;
    Vec3i lo[most];           // the first cell of the triangle's box
    Vec3i n[most];            // cells of its box, 1..8 along each axis
    double p[9][most];        // its corners a, b, c as x, y, z, from `lo`
    std::uint64_t box[most];  // the box's rows along x: byte y, bit x

    // Out: cells (lo.x + x, lo.y + y, lo.z + z) as bit x of byte y of layer z, for z < n.z.
    std::uint64_t layer[reach][most];

    // Precondition: the box, count < most.
    void add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3i& first, const Vec3i& cells);
};

// Fills in `layer`, by the tests that surface_cells.cpp derives. `interior`: the cells' insides
// (CellShape::interior). Bits are the same for any width of vectors.
void find_cells(SmallTriangles& triangles, bool interior);

}  // namespace geometry
