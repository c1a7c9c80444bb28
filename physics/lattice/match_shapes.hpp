#pragma once

// Shape matching: from the particles of each region to its rotation, and from there to where the
// particle would be if the region were rigid (lattice.hpp has the equations).

#include "physics/lattice/step_state.hpp"

namespace physics {

// The sums of T_r X_i, weighed, into the particles' quads of step.sums.
template <class T> void find_goals(StepState<T>& step);

}  // namespace physics
