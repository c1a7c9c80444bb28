#pragma once

// The shape in which a body of bricks is at rest under its loads.

#include "physics/bricks/bricks.hpp"

namespace physics {

// `state` as it is when all forces are balanced and nothing moves: one step so long that inertia is
// nothing beside the forces, by Newton's method, or after shorter ones where that does not
// converge. Rates and substeps of `options` do not count. The report says whether it converged, and
// warns where not. Throws std::invalid_argument as advance() does, and when a part of the body has
// no pin: it would fall for ever.
State settle(const BricksBody& body, State state, const Loads& loads, const StepOptions& options);

}  // namespace physics
