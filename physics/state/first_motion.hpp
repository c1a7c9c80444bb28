#pragma once

// The velocity and spin that a body starts with.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/state.hpp"

#include <span>

namespace physics {

// Adds to a state's velocities: `velocity` (m/s) and a turn `spin` (rad/s) about the centre of mass
// of the cubes. Throws std::invalid_argument when the state is of other cubes, and when a velocity
// becomes too large for a number.
void add_first_motion(State& state, const geometry::Cubes& cubes, const Vec3& velocity,
                      const Vec3& spin);

// Of the corners from `first` on alone, by their masses (kg), about their own centre.
void add_first_motion(State& state, std::size_t first, std::span<const double> mass,
                      const Vec3& velocity, const Vec3& spin);

}  // namespace physics
