#pragma once

// Elastic parts that pins let turn, as about a hinge, or turn themselves, as a propeller, and that
// touch nothing: how they turn within a stage (free_parts.hpp has the same of free parts).
//
// Linear forces about where a stage starts stretch what turns far in it by the square of the angle,
// and implicit Euler slows what turns. A part whose pins lie at one point or on one line turns
// about that with the spin that it has, and goes with its pins. One with other pins turns as they
// are turned within the stage, as far as it has the spin itself:
//   x^ = p + tau vp + R(tau s) (x0 - p),   w^ = vp + s x (x^ - p^)
// with p where its pins are in the mean, at vp. The stage takes it from there, x = x^ + tau (w -
// w^), with forces that are linear about x^, and with v0 changed as a rigid body so that its
// angular momentum about p, or about the axis through it, is what it was. The forces from outside
// act with the arms that they have where the stage begins: of a pendulum that is symplectic Euler,
// which neither gains nor loses in the mean.

#include "physics/bricks/stage.hpp"

namespace physics {

// Puts x0, v0, w and b of these parts where they turn to. For stages with turns_start.
void turn_pinned_parts(Stage& stage);

}  // namespace physics
