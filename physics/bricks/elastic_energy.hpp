#pragma once

// The elastic energy that a body of bricks holds.

#include "physics/bricks/bricks_body.hpp"
#include "physics/state/state.hpp"

namespace physics {

// At a state's places, with its rest shapes. J.
double elastic_energy(const BricksBody& body, const State& state);

}  // namespace physics
