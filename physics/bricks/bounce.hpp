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
//
// The speeds of parts before and after are told at the same place, with the arms that it has where
// the stage begins, and an impulse acts there: what turns within the stage would otherwise differ
// in speed from itself. Rigid parts then turn on from there with the momentum that they have got,
// and what they get adds no energy (impact_energy.hpp).

#include "physics/bricks/stage.hpp"

#include <map>

namespace physics {

// Sets how each of the stage's touches bounces, from where the stage starts, and whether any of
// them is struck.
void aim_bounces(Stage& stage);

// When the first of them hits, s after the start of the stage; tau: none does, or all from the
// start.
double first_hit(const Stage& stage);

// Who meets: part, whether the other is a part, and which.
struct Meeting {
    std::uint32_t part = 0;
    bool parts = false;
    std::uint32_t other = 0;

    auto operator<=>(const Meeting&) const = default;
};
// Of each that bounces, how much it is a rigid body by the end of a stage: 1 where it has a third
// of the speed that it is to leave with by then, or more, 0 where it does not rise yet.
using Risen = std::map<Meeting, double>;

// A stage that was solved.
struct SolvedStage {
    const Aligned<double>&x, &v;  // m, m/s: as it began
    const Aligned<double>& end;   // m, x at its end as solved, before rigid parts turned
};

Risen risen(const Stage& stage, const SolvedStage& solved);

// Where the error chooses the steps: 0 for what is better followed while it is squashed, since
// steps of that error, `finest` seconds at least, leave it more speed than its bounce; 1 for what
// bounces; rigid_yet for what bounces unless a shorter stage tells more of it.
inline constexpr double rigid_yet = 2;
Risen risen_by_error(const Stage& stage, const SolvedStage& solved, double finest);

// Gives parts that rise again the rest of the speed that they are to leave with, and takes off what
// impacts add to the energy of rigid parts: w changes, and x0 of rigid parts. `risen`: of a longer
// stage; what is not in it does not rise.
void finish_impacts(Stage& stage, const SolvedStage& solved, const Risen& risen);

}  // namespace physics
