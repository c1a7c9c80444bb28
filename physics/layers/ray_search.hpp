#pragma once

// A sample on its ray, on its way to where D = c.

#include "geometry/base/vec.hpp"

#include <cmath>
#include <cstdint>

namespace physics {

struct SearchRay {
    std::uint32_t sample = 0;
    geometry::Vec3 origin, direction;       // m, unit; in the world
    double t = 0, inside = 0, outside = 0;  // m: D - c > 0 at `inside`, not at `outside`

    geometry::Vec3 point() const { return origin + t * direction; }
};

// Goes on by Newton's step for D - c = phi, or to the middle of the bracket where that leaves it.
// Returns false, and stays, where it has arrived.
inline bool step(SearchRay& ray, double phi, double phi_slope, double tolerance)
{
    (phi > 0 ? ray.inside : ray.outside) = ray.t;
    double next = ray.t - phi / phi_slope;
    if (!(phi_slope < 0 && next >= ray.inside && next <= ray.outside)) {
        next = 0.5 * (ray.inside + ray.outside);
    }
    if (!(std::abs(next - ray.t) > tolerance && ray.outside - ray.inside > tolerance)) return false;
    ray.t = next;
    return true;
}

}  // namespace physics
