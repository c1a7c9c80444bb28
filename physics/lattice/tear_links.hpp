#pragma once

// Fracture: links longer than they can bear are gone, for good.

#include "physics/lattice/step_state.hpp"

namespace physics {

// Breaks links that are longer than they can bear. Returns whether any broke: then regions have to
// be found anew.
bool tear_links(FrameState& step);

}  // namespace physics
