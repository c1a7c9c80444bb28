#pragma once

// Impacts of a stage: points of the surface that hit what bounces, by Newton's law of restitution.
//
// A point that comes at more than a threshold to what it touches, and would be in it within the
// stage, is pushed until it leaves with a share e of the speed that it came with:
//   n . (v' - v_other') = -e n . (v - v_other)
// The stage begins at the hit; what the steady forces take of v' until it ends is off.
// In the equations of the stage its plane is moved out by as much as that takes (PlaneTouch). That
// gives the velocity of the surface. The part behind it is squashed meanwhile, and what that takes
// is lost to vibration where the stage is short: a part that rises again as a whole gets the rest
// of its speed by an impulse on it as a rigid body. A soft part does not rise yet; it gets none,
// and comes back by its elasticity. Which of them it is must not depend on when in a step the
// impact falls: a stage that begins at an impact and is shorter than a whole step is asked again
// with the length of one. What takes longer than a
// step to rise leaves with a share that depends on when it hits. Slower than the threshold, twice
// the speed that the steady forces give within the stage, nothing bounces, so that things come to
// rest. The midpoint rule and sdirk2 keep vibration, and points have velocities that lead nowhere
// within a step: there v is that of the part as a rigid body.

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/stage.hpp"

namespace physics {

// How a point comes to its plane, along the normal, where a stage starts.
struct Coming {
    double gap;           // m
    double speed;         // m/s, inward
    double acceleration;  // m/s^2, inward, of the steady forces
};

class Comings {
public:
    explicit Comings(const Stage& stage) : stage_(stage) {}

    Coming of(const PlaneTouch& touch);

private:
    // How fast the point goes inward with its part as a whole, m/s.
    double speed_as_a_whole(const PlaneTouch& touch);

    const Stage& stage_;
    std::vector<RigidPart> parts_;  // where the stage starts; empty: not needed yet
};

// Whether the point is in what it touches before the step ends, and not just because it lies on
// it.
bool hits(const Stage& stage, const Coming& in);

// Where the point of a touch is when corners are at x.
Vec3 place_of_touch(const PlaneTouch& touch, const Aligned<double>& x);

// Of a part as a rigid body, where p is, m/s.
Vec3 velocity_at(const RigidPart& part, const Vec3& p);

// Sets how each of the stage's touches bounces, from where the stage starts, and whether any of
// them is struck.
void aim_bounces(Stage& stage);

// When the first of them hits, s after the start of the stage; tau: none does, or all from the
// start.
double first_hit(const Stage& stage);

}  // namespace physics
