#include "physics/far_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace physics {

std::vector<std::string> far_forces(const geometry::Cubes& cubes, std::span<const Force> forces)
{
    std::vector<std::string> out;
    for (std::size_t i = 0; i < forces.size(); ++i) {
        const Force& force = forces[i];
        if (force.kind != Force::Kind::point || force.force.isZero(0)) continue;
        const double reach = force.radius + std::sqrt(3.0) * cubes.size;
        const Vec3 at = (force.position - cubes.origin) / cubes.size;  // in cubes
        const bool near = std::any_of(cubes.cell.begin(), cubes.cell.end(), [&](const auto& cell) {
            double away_sq = 0;
            for (int d = 0; d < 3; ++d) {
                const double away =
                    std::max({cell[d] - at[d], at[d] - cell[d] - 1, 0.0}) * cubes.size;
                away_sq += away * away;
            }
            return away_sq <= reach * reach;
        });
        if (near) continue;
        out.push_back(fmt::format(
            "point force {} of {} reaches no material: all of it acts on the corner nearest to its "
            "position, which is a place in the shape at rest; move it there or widen its radius",
            i + 1, forces.size()));
    }
    return out;
}

}  // namespace physics
