#pragma once

// Which skeletons may reach a place: the boxes of their influence in a uniform grid.
//
//      +-----+-----+-----+-----+      boxes A and B, half of whose mean width is a cell;
//      |     | A---+-----+--,  |      a cell lists every skeleton whose box touches it:
//      |     | |   |  B--+--+--+--,     "A", "A B", "B", ...
//      +-----+-+---+--+--+--+--+  |
//      |     | '---+--+--+--'  |  |
//      |     |     |  '--+-----+--'
//      +-----+-----+-----+-----+
//
// A point outside the grid counts as in the nearest cell, so that a question need not be cut first.

#include "geometry/base/vec.hpp"

#include <span>
#include <vector>

namespace geometry {

struct FieldGrid {
    Vec3 lo = Vec3::Zero();
    double cell = 1;  // m
    Vec3i dims = Vec3i::Zero();
    std::vector<std::uint32_t> first;     // cells + 1, into skeleton
    std::vector<std::uint32_t> skeleton;  // ascending within a cell

    std::size_t cell_count() const { return first.empty() ? 0 : first.size() - 1; }
};

// Of skeletons with these boxes of influence; empty and endless boxes are left out. Cells about
// half as wide as a mean box; at most 16 a skeleton, so that a few far outliers cannot blow the
// grid up.
FieldGrid make_field_grid(std::span<const Box> influence);

// The cell that holds p, or the nearest one, and its number.
inline Vec3i cell_of(const FieldGrid& grid, const Vec3& p)
{
    const Vec3 x = ((p - grid.lo) / grid.cell).array().floor();
    const Vec3 last = (grid.dims.array() - 1).cast<double>();
    return x.cwiseMax(0.0).cwiseMin(last).cast<int>();
}

inline std::size_t cell_index(const FieldGrid& grid, const Vec3i& c)
{
    return static_cast<std::size_t>(c.x()) +
           static_cast<std::size_t>(grid.dims.x()) *
               (static_cast<std::size_t>(c.y()) +
                static_cast<std::size_t>(grid.dims.y()) * static_cast<std::size_t>(c.z()));
}

// visit(number) for every cell that the box touches.
template <class Visit> void for_cells(const FieldGrid& grid, const Box& box, const Visit& visit)
{
    const Vec3i lo = cell_of(grid, box.lo), hi = cell_of(grid, box.hi);
    for (int z = lo.z(); z <= hi.z(); ++z) {
        for (int y = lo.y(); y <= hi.y(); ++y) {
            for (int x = lo.x(); x <= hi.x(); ++x) visit(cell_index(grid, {x, y, z}));
        }
    }
}

// The box of all cells.
inline Box extent(const FieldGrid& grid)
{
    Box box;
    box.add(grid.lo);
    box.add(grid.lo + grid.cell * grid.dims.cast<double>());
    return box;
}

}  // namespace geometry
