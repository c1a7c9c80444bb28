#pragma once

// The forces that move layered bodies, with their stiffness and damping, for one step's system.

#include "physics/layered.hpp"
#include "physics/layered_system.hpp"

namespace physics {

// All of them: contacts and stops, weight, air, springs, hinges, and what particles do to each
// other.
void add_forces(const LayeredScene& scene, const LayeredMoment& moment, const LayeredWorld& world,
                LayeredSystem& system);

}  // namespace physics
