#pragma once

// Impacts of a stage: points of the surface that hit what bounces, by Newton's law of restitution.
//
// A point that comes at more than a threshold to what it touches, and would be in it within the
// stage, is pushed until it leaves with a share e of the speed that it came with:
//   n . (v' - v_other') = -e n . (v - v_other)
// In the equations of the stage its plane is moved out by as much as that takes (PlaneTouch). That
// gives the velocity of the surface. The part behind it is squashed meanwhile, and what that takes
// is lost to vibration where the stage is short: a part that rises again as a whole gets the rest
// of its speed by an impulse on it as a rigid body. A soft part does not rise yet; it gets none,
// and comes back by its elasticity. Slower than the threshold, twice the speed that the steady
// forces give within the stage, nothing bounces, so that things come to rest.

#include "physics/bricks/stage.hpp"

namespace physics {

// Sets how each of the stage's touches bounces, from where the stage starts, and whether any of
// them is struck.
void aim_bounces(Stage& stage);

// When the first of them hits, s after the start of the stage; tau: none does, or all from the
// start.
double first_hit(const Stage& stage);

// Gives parts that rise again after a stage which began with these x and v the rest of the speed
// that they are to leave with: w changes.
void make_up(Stage& stage, const Aligned<double>& before_x, const Aligned<double>& before_v);

}  // namespace physics
