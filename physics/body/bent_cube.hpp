#pragma once

// A cube whose corners have moved: p(u) = sum w_a(u) x_a, with w the trilinear weights
// (geometry/cubes/trilinear.hpp) of u, 0..1 along the cube's own axes.

#include "geometry/base/vec.hpp"

#include <array>
#include <optional>

namespace physics {

using geometry::Mat3;
using geometry::Vec3;

// A place in such a cube, and what the cube's axes become there.
struct InCube {
    Vec3 u;
    Mat3 axes;  // m, columns dx / du
};

// The place u, with p(u) in p.
InCube place_in(const std::array<Vec3, 8>& x, const Vec3& u, Vec3& p);

// u with p(u) = p, by Newton's method. None where p is further than `slack` (cubes) from the cube
// of `size` (m) at rest, or the cube is flat or inside out there.
std::optional<InCube> find_in_cube(const std::array<Vec3, 8>& x, double size, const Vec3& p,
                                   double slack);

}  // namespace physics
