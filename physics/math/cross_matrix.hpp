#pragma once

// The cross product as a matrix.

#include "geometry/base/vec.hpp"

namespace physics {

// [a]x: cross_matrix(a) * b = a x b.
inline geometry::Mat3 cross_matrix(const geometry::Vec3& a)
{
    geometry::Mat3 m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

}  // namespace physics
