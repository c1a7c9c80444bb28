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
    add_first_motion(state, 0, corner_masses(cubes), velocity, spin);
}

void add_first_motion(State& state, std::size_t first, std::span<const double> mass,
                      const Vec3& velocity, const Vec3& spin)
{
    Vec3 centre = Vec3::Zero();
    double total = 0;
    for (std::size_t k = 0; k < mass.size(); ++k) {
        centre += mass[k] * state.x[first + k];
        total += mass[k];
    }
    if (total > 0) centre /= total;
    for (std::size_t k = 0; k < mass.size(); ++k) {
        state.v[first + k] += velocity + spin.cross(state.x[first + k] - centre);
        if (state.v[first + k].allFinite()) continue;
        throw std::invalid_argument(
            "the initial velocity and spin make a corner faster than numbers go: use smaller ones");
    }
}

}  // namespace physics
