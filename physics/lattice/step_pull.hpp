#pragma once

// The lattice's own impulses of a step: towards the goals of its regions, damping, and a
// membrane's.

#include "physics/lattice/step_state.hpp"

namespace physics {

// Adds them to the velocities, after find_goals(). What rounding leaves of force and torque is a
// rigid motion that push_from_outside() takes out again.
template <class T> void pull(StepState<T>& step);

}  // namespace physics
