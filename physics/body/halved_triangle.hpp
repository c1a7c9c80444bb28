#pragma once

// A triangle and its two halves, cut through the middle of its longest side.

#include "geometry/base/vec.hpp"

#include <array>

namespace physics {

struct HalvedTriangle {
    using Corners = std::array<geometry::Vec3, 3>;  // m

    explicit HalvedTriangle(const Corners& t)
    {
        std::size_t from = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const double side = (t[(i + 1) % 3] - t[i]).norm();
            if (side > longest) longest = side, from = i;
        }
        const geometry::Vec3 &p = t[from], &q = t[(from + 1) % 3], &r = t[(from + 2) % 3];
        const geometry::Vec3 middle = (p + q) / 2;
        first = {p, middle, r};
        second = {middle, q, r};
    }

    double longest = 0;  // m, side
    Corners first, second;
};

}  // namespace physics
