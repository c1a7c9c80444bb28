#pragma once

// Where in space rays have to look for a surface: cells of a coarse grid, of which interval bounds
// of the field (iso_grid.hpp) keep those that the surface may pass, each with a bound of the
// field's slope in it.
//
//   . . . . . .      a ray leaps over all cells but those marked x, and in these over every
//   . x x x x .      stretch in which the field cannot reach 0: (|f| - leap) / slope long at least
//   . x . . x .
//   . x x x x .
//
// Galin, Guerin, Paris, Peytavie. Segment tracing using local Lipschitz bounds. Computer Graphics
// Forum 39(2), 2020, bounds the slope over a part of the ray; here it is bounded over a cell, once
// for all rays.
// Aydinlilar, Zanni. Forward inclusion functions for ray-tracing implicit surfaces. Computers &
// Graphics 114, 2023.

#include "geometry/fields/iso_field.hpp"

#include <vector>

namespace geometry {

struct IsoCells {
    Vec3 lo = Vec3::Zero();  // m, the grid's lowest corner
    double cell = 1;         // m
    Vec3i dims = Vec3i::Zero();
    // Of each cell, x first; see Steepness. A slope of 0: the surface does not pass there.
    std::vector<float> slope, leap;
    Box bounds;  // m, of the cells that it may pass; empty: none

    std::size_t index(const Vec3i& at) const
    {
        return static_cast<std::size_t>(at.x() + dims.x() * (at.y() + dims.y() * at.z()));
    }
    Box box(const Vec3i& at) const
    {
        Box box;
        box.add(Vec3(lo + cell * at.cast<double>()));
        box.add(Vec3(lo + cell * (at.array() + 1).matrix().cast<double>()));
        return box;
    }
};

// Cells of which about `along` lie along the longest edge of the field's domain.
IsoCells iso_cells(const IsoField& field, int along = 64);

}  // namespace geometry
