#pragma once

// Single numbers of a state: the largest speed, the kinetic energy.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/state.hpp"

namespace physics {

// Speed of the fastest corner; not a number if any velocity is not. m/s.
double largest_speed(const State& state);

// 1/2 v^T M v over the corners of `cubes`, with the mass that the state says they have. J. Throws
// std::invalid_argument when state and cubes have different numbers of corners.
double kinetic_energy(const State& state, const geometry::Cubes& cubes);

}  // namespace physics
