#pragma once

// Cuts polygons into triangles.

#include "geometry/base/vec.hpp"

#include <span>
#include <vector>

namespace geometry {

// Cuts the polygon whose corners are `corner`, into `positions`, and adds its corner count - 2
// triangles to `out`, wound as the polygon. Concave polygons are cut along diagonals inside (ears:
// Meisters. Polygons have ears. American Mathematical Monthly 82(6), 1975) in the plane of their
// mean normal; a quad along the shorter diagonal when both lie inside. Where no cut is right (it
// crosses itself, is flat or not finite, has more than 5,000 corners and is concave) it becomes a
// fan.
void triangulate(std::span<const std::uint32_t> corner, std::span<const Vec3f> positions,
                 std::vector<Triangle>& out);

}  // namespace geometry
