#pragma once

// The trilinear weights of a place in the unit cube: of corner a, which is at
// ((a & 1), (a >> 1 & 1), (a >> 2 & 1)). Their sum is 1, outside of the cube too.

#include "geometry/base/vec.hpp"

#include <array>

namespace geometry {

inline std::array<double, 8> trilinear_weights(const Vec3& u)
{
    std::array<double, 8> w;
    for (unsigned a = 0; a < 8; ++a) {
        w[a] = ((a & 1) ? u.x() : 1 - u.x()) * ((a & 2) ? u.y() : 1 - u.y()) *
               ((a & 4) ? u.z() : 1 - u.z());
    }
    return w;
}

}  // namespace geometry
