#include "physics/state/measure.hpp"

#include "geometry/mesh/measure.hpp"
#include "physics/state/cube_mass.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace physics {

double largest_speed(const State& state)
{
    double largest = 0;
    for (const Vec3& v : state.v) {
        const double speed = v.norm();
        if (geometry::exceeds(speed, largest)) largest = speed;
    }
    return largest;
}

double kinetic_energy(const State& state, const geometry::Cubes& cubes)
{
    if (state.v.size() != cubes.corner_count()) {
        throw std::invalid_argument(fmt::format(
            "expected a state of {} corners, found {} corners. Was it made with other cubes?",
            cubes.corner_count(), state.v.size()));
    }
    double sum = 0;
    if (state.brick_mass) {
        const std::vector<Vec3> momentum = brick_momenta(cubes, state.v);
        for (std::size_t i = 0; i < momentum.size(); ++i) sum += 0.5 * momentum[i].dot(state.v[i]);
        return sum;
    }
    const std::vector<double> mass = geometry::corner_masses(cubes);
    for (std::size_t i = 0; i < mass.size(); ++i) sum += 0.5 * mass[i] * state.v[i].squaredNorm();
    return sum;
}

}  // namespace physics
