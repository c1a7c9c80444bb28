#pragma once

// The energy of rigid parts that push each other in a stage: they add nothing to it.
//
// Parts that push each other, or that joints link, are a group. With J and j what each gets of the
// others and of colliders within the stage (N s, N m s about its centre), F and T what acts from
// outside, and W the work of colliders that move,
//   m v' = m v + tau F + J,   L' = L + tau T + j
// and the energy of the group, less W and the work of F and T on the way tau v', changes by
//   G = sum v . J + s . j + (J . J / m + j . I^-1 j) / 2 - tau^2/2 (F . F / m + T . I^-1 T) - W
// All of it is told where the stage begins, which is where something hits: what turns freely from
// there on keeps its momentum and its energy. Planes that stay as parts turn, points that leave by
// a law of their own each (bounce.hpp), and what is pushed out of something that it leaves anyway,
// make G greater than 0. Then the velocities u' of the group against its motion as one rigid body,
// or against the colliders that it touches, are multiplied by the f < 1 that makes it 0:
//   (f^2 - 1) E - (f - 1) P + G = 0,   E = the energy of motion of u', P = tau sum F . u' + T . s'
// That keeps the momentum and the angular momentum of a free group, parts that leave each other
// still do, and what rests stays as it is. (A factor on the velocities: LaBudde, Greenspan. Energy
// and momentum conserving methods of arbitrary order. Numerische Mathematik 1976.)
//
// Before that, what J and j of a free group leave over on the whole is taken off, by the least
// change in the norm of M: contacts turn within a stage, and do not push both parts at the same
// place to its end.
//
// What comes out of something slowly where nothing hits may gain as much as one that lies deep
// needs to rise (step_energy.hpp). Groups that pins hold, or that have elastic parts, stay as they
// are: of these, it is not known how much energy they may have.

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/stage.hpp"

#include <span>

namespace physics {

// A stage that was solved.
struct SolvedStage {
    const Aligned<double>&x, &v;  // m, m/s: as it began
    const Aligned<double>& end;   // m, x at its end as solved, before rigid parts turned
};

// What pushes a rigid part in the stage.
struct Push {
    const PlaneTouch* touch = nullptr;
    double impulse = 0;  // N s
    bool hits = false;   // it arrives, faster than what rests (bounce.hpp)
};

// Parts are those before and after the stage, with their centres and inertia as it began; `after`
// changes. `work`: J, of colliders by what `after` has of impulses besides the stage's contacts, by
// part.
void keep_impact_energy(const Stage& stage, const SolvedStage& solved, std::span<const Push> pushes,
                        const std::vector<RigidPart>& before, const std::vector<double>& work,
                        std::vector<RigidPart>& after);

}  // namespace physics
