#pragma once

// Where on its way a fast point is looked for in what it may have gone through.

#include "geometry/base/box_tree.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

// Places on the way to a point: `from`, from + step .. `to`, in shares of `of`; `of` is the point.
struct Places {
    double from, to, step, of;
};

// Those in a box, of `strides` on the `way` to p: at most 256, and none where the way misses it.
inline Places places_within(const geometry::Box3f& box, const geometry::Vec3& p,
                            const geometry::Vec3& way, double strides)
{
    constexpr double most = 256;
    double begin = 0, end = 1;
    for (Eigen::Index k = 0; k < 3; ++k) {
        if (std::abs(way[k]) < 1e-12) continue;
        const auto [near, far] = std::minmax(
            {1 + (double(box.lo[k]) - p[k]) / way[k], 1 + (double(box.hi[k]) - p[k]) / way[k]});
        begin = std::max(begin, near), end = std::min(end, far);
    }
    const double from = std::floor(begin * strides), to = std::ceil(end * strides);
    return {from, to, std::max(1.0, (to - from) / most), strides};
}

}  // namespace physics
