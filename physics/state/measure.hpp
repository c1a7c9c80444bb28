#pragma once

// Single numbers of a state: the largest speed, the kinetic energy.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/state.hpp"

namespace physics {

// Speed of the fastest corner; not a number if any velocity is not. m/s.
double largest_speed(const State& state);

// sum 1/2 m v^2 over the corners of `cubes`, whose masses these are. J. Throws
// std::invalid_argument when state and cubes have different numbers of corners.
double kinetic_energy(const State& state, const geometry::Cubes& cubes);

}  // namespace physics
