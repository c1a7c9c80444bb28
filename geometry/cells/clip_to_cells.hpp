#pragma once

// Cuts polygons along the planes between cells, so that each piece lies in one cell.

#include "geometry/base/vec.hpp"

#include <array>
#include <cmath>

namespace geometry {

// A convex polygon that lies in a plane. A triangle clipped by six planes has at most 9 corners.
struct Polygon {
    std::array<Vec3, 10> p;
    std::size_t n = 0;

    void add(const Vec3& q) { p[n++] = q; }
    double area() const
    {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 2; i < n; ++i) sum += (p[i - 1] - p[0]).cross(p[i] - p[0]);
        return 0.5 * sum.norm();
    }
};

// Cuts `whole` at coordinate `axis` = at.
inline void cut(const Polygon& whole, int axis, double at, Polygon& below, Polygon& above)
{
    below.n = above.n = 0;
    for (std::size_t i = 0; i < whole.n; ++i) {
        const Vec3 &a = whole.p[i], &b = whole.p[i + 1 < whole.n ? i + 1 : 0];
        const double da = a[axis] - at, db = b[axis] - at;
        if (da <= 0) below.add(a);
        if (da >= 0) above.add(a);
        if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
            Vec3 m = a + da / (da - db) * (b - a);
            m[axis] = at;
            below.add(m);
            above.add(m);
        }
    }
}

namespace detail {

// Pieces of fewer than `least` corners are left out.
template <std::size_t least, class Emit>
void clip_along(Polygon& rest, int axis, Vec3i& cell, const Emit& emit)
{
    if (axis < 0) {
        emit(cell, rest);
        return;
    }
    double lo = rest.p[0][axis], hi = lo;
    for (std::size_t i = 1; i < rest.n; ++i) {
        lo = std::min(lo, rest.p[i][axis]);
        hi = std::max(hi, rest.p[i][axis]);
    }
    const int first = static_cast<int>(std::floor(lo)), last = static_cast<int>(std::floor(hi));
    Polygon below, above;
    Polygon *now = &rest, *next = &above;
    for (cell[axis] = first; cell[axis] < last; ++cell[axis]) {
        cut(*now, axis, cell[axis] + 1, below, *next);
        if (below.n >= least) clip_along<least>(below, axis - 1, cell, emit);
        std::swap(now, next);
    }
    cell[axis] = last;
    if (now->n >= least) clip_along<least>(*now, axis - 1, cell, emit);
}

}  // namespace detail

// Calls emit(cell, piece) for the pieces of a polygon in each cell that it passes, in lattice
// coordinates; some may have no area. They sum to the polygon's.
template <class Emit> void clip_polygon_to_cells(Polygon polygon, const Emit& emit)
{
    if (polygon.n < 3) return;
    Vec3i cell;
    detail::clip_along<3>(polygon, 2, cell, emit);
}

// Calls emit(cell, piece) for every cell that holds a point of the polygon, a face belonging to the
// cell above it (CellShape::half_open). Pieces may be segments and points, of two corners and one.
template <class Emit> void touch_cells(Polygon polygon, const Emit& emit)
{
    if (polygon.n == 0) return;
    Vec3i cell;
    detail::clip_along<1>(polygon, 2, cell, emit);
}

// Calls emit(cell, area) for the pieces of triangle abc likewise.
template <class Emit>
void clip_to_cells(const Vec3& a, const Vec3& b, const Vec3& c, const Emit& emit)
{
    Polygon triangle;
    triangle.add(a);
    triangle.add(b);
    triangle.add(c);
    clip_polygon_to_cells(
        triangle, [&](const Vec3i& cell, const Polygon& piece) { emit(cell, piece.area()); });
}

}  // namespace geometry
