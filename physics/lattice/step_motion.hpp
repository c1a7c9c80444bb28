#pragma once

// What acts on the particles from outside in a step, and their motion.

#include "physics/lattice/step_state.hpp"

namespace physics {

// Finds the middle of the particles, from which single precision measures. Before the first step;
// the phases below keep it.
void find_origin(FrameState& step);

// Adds gravity, point forces, wind and drag to the velocities, and takes out the rigid motion that
// pull() has left. Where nothing can be touched, particles move too, in the same pass.
void push_from_outside(FrameState& step);

// Changes the velocities so that colliders, balls and other bodies stay out of each other.
// `share`: of the frame that is over with this step, as below.
void collide(FrameState& step, double share);

// Moves the particles, pins and balls.
void move(FrameState& step, double share);

}  // namespace physics
