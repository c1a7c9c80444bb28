#pragma once

// The shape in which a body of bricks is at rest under its loads.

#include "physics/bricks/bricks.hpp"

namespace physics {

// `state` as it is when all forces are balanced and nothing moves: one step so long that inertia is
// nothing beside the forces, by Newton's method, or after shorter ones where that does not
// converge. Parts without pins fall until they lie on colliders or on each other, in steps that
// each begin at rest: they neither swing nor bounce. Substeps of `options` do not count.
// The report says whether it converged, and warns where not. Throws std::invalid_argument as
// advance() does, and where a part without a pin falls, slides or rolls on for ever.
State settle(const BricksBody& body, State state, const Loads& loads, const StepOptions& options);

}  // namespace physics
