#pragma once

// Solves the system of a step of layered bodies: the change of velocity of every frame and corner.

#include "physics/layered_bodies/layered_system.hpp"
#include "physics/state/state.hpp"

namespace physics {

// The least of  dv^T A dv / 2 - dv . right + sum stiffness min(0, u + room)^2 / 2  over stops,
// convex and quadratic in pieces. Newton's method: those that would be passed are held, the others
// let go, until that is what comes out; a step that does not go down is halved. Adds to the
// report's iterations, and says where it did not converge.
std::vector<Vec6> solve(LayeredSystem& system, Report& report);

}  // namespace physics
