#pragma once

// Bodies that fall freely.
//
// Implicit Euler moves what falls by tau (v + tau a), which is tau^2 a / 2 too far in each step: a
// fourth of the way after four. As the acceleration a of a part as a whole is known beforehand, x0
// of the stage is moved by -tau^2 a / 2, and the stage ends where a parabola does, with the
// velocity that it has there. Parts that touch each other and nothing else fall as one. What would
// touch a collider in the stage is not moved: contact is that of implicit Euler.
//
// Drag tells implicit Euler how far to go: m (v - v0) = F t - D (x - x0) over any time. The more of
// its velocity a part loses in a step to drag, the less it is moved, and not at all from a fourth
// on.

#include "physics/bricks/stage.hpp"

namespace physics {

// Moves stage.x0 of parts, along axes that nothing holds, by stage.lifted, if stage.turns_start:
// under loads as they are, and drag as it is where the stage ends.
void lift_free_parts(Stage& stage);

}  // namespace physics
