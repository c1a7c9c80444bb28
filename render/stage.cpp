#include "render/stage.hpp"

#include "geometry/mesh/measure.hpp"

#include <algorithm>

namespace render {

bool is_level_plane(const physics::Collider& collider)
{
    return collider.kind == physics::Collider::Kind::plane &&
           (collider.pose.linear() * Vec3::UnitY()).normalized().y() > 0.9999;
}

std::optional<double>
solid_floor(std::span<const std::shared_ptr<const physics::Collider>> colliders)
{
    std::optional<double> height;
    for (const auto& c : colliders) {
        if (!is_level_plane(*c)) continue;
        const double here = c->pose.translation().y();
        height = std::max(height.value_or(here), here);
    }
    return height;
}

Box stage_of(const TriMesh* rest, const geometry::Cubes* cubes, const Box& drawn,
             const std::optional<double>& floor)
{
    Box box;
    if (rest) {
        box = geometry::bounds(*rest);
    } else if (cubes) {
        for (const Vec3& p : geometry::corner_positions(*cubes)) box.add(p);
    } else {
        box = drawn;
    }
    if (floor && !box.empty() && *floor < box.lo.y() && box.lo.y() - *floor < 3 * box.diagonal()) {
        box.lo.y() = *floor;
    }
    return box;
}

}  // namespace render
