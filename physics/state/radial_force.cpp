#include "physics/state/radial_force.hpp"

#include <algorithm>

namespace physics {

Vec3 radial_acceleration(const Force& radial, const Vec3& place)
{
    const Vec3 from = place - radial.position;
    const double squared = from.squaredNorm() / (radial.radius * radial.radius);
    if (!(squared < 1)) return Vec3::Zero();
    const double near = 1 - squared;
    const double scale = near * near / std::max(from.norm(), radial.radius / 10);
    return scale * (radial.outward * from + radial.swirl.cross(from));
}

}  // namespace physics
