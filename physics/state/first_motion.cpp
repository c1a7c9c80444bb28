#include "physics/state/first_motion.hpp"

#include <stdexcept>

namespace physics {

void add_first_motion(State& state, const geometry::Cubes& cubes, const Vec3& velocity,
                      const Vec3& spin)
{
    const std::size_t n = cubes.corner_count();
    if (state.x.size() != n || state.v.size() != n) {
        throw std::invalid_argument("start state: expected " + std::to_string(n) +
                                    " corners, found " + std::to_string(state.x.size()) +
                                    ". Was it made with other cubes?");
    }
    const auto mass = corner_masses(cubes);
    Vec3 centre = Vec3::Zero();
    double total = 0;
    for (std::size_t k = 0; k < n; ++k) {
        centre += mass[k] * state.x[k];
        total += mass[k];
    }
    if (total > 0) centre /= total;
    for (std::size_t k = 0; k < n; ++k) state.v[k] += velocity + spin.cross(state.x[k] - centre);
}

}  // namespace physics
