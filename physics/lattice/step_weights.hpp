#pragma once

// The regions that a step sums over and how strongly each pulls: rates of the material or as given,
// what steps this long can bear, pins, and links that are broken.

#include "physics/lattice/step_state.hpp"

namespace physics {

// The regions of the lattice without the links of state.broken, and the weights of each. Anew
// whenever a link breaks.
template <class T> void use_regions(StepState<T>& step);

}  // namespace physics
