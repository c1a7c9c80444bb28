#pragma once

// Bodies that fall freely.
//
// Implicit Euler moves what falls by tau (v + tau a), which is tau^2 a / 2 too far in each step: a
// fourth of the way after four. As the acceleration a of a part as a whole is known beforehand, x0
// of the stage is moved by -tau^2 a / 2, and the stage ends where a parabola does, with the
// velocity that it has there. What would touch something in the stage is not moved: contact is that
// of implicit Euler.

#include "physics/bricks/stage.hpp"

namespace physics {

// Moves stage.x0 of parts, along axes that nothing holds, by stage.lifted, if stage.turns_start:
// under loads as they are, and drag as it is where the stage ends.
void lift_free_parts(Stage& stage);

}  // namespace physics
