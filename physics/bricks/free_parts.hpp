#pragma once

// Parts of a body that nothing holds: how they turn within a stage, and the momentum that they
// keep.
//
// Implicit Euler of a point on a circle moves it along a chord: the velocity at its end points half
// a step back, and a linearisation where the stage starts stretches the circle. Both are errors of
// the step, that a stiff body must not feel. The motion of a part that is rigid, with the velocity
// vc of its centre and its spin s = I^-1 L, is known to its end:
//   x^ = c + tau vc + R(tau s) (x0 - c),   w^ = vc + s x (x^ - its centre)
// The stage takes it from there, x = x^ + tau (w - w^): as before with x0 = x^ - tau w^ (an error
// of the step's own order), with forces that are linear about x^, and with v0 turned so that it has
// the angular momentum of the part there, at x^.
//
// What a stage's solution leaves over of a free part's momenta is then put right by the least
// change of w, in the norm of M, that does so: w moves as a rigid body (LaBudde, Greenspan. Energy
// and momentum conserving methods of arbitrary order. Numerische Mathematik 1976, for the idea of
// keeping both by construction).

#include "physics/bricks/rigid_part.hpp"
#include "physics/bricks/stage.hpp"

#include <cstdint>
#include <vector>

namespace physics {

std::vector<RigidPart> rigid_parts(const Stage& stage, const Aligned<double>& x,
                                   const Aligned<double>& v);

// The axes along which pins hold each part, as bits; all of them where it touches something in the
// stage as it is. 0: it is free.
std::vector<std::uint8_t> held_parts(const Stage& stage);

// Lets a stage that touches stage.contacts start from x^, w^ of the parts that are not
// held: with x0 and v0 as above if stage.turns_start; otherwise they stay, and forces are linear
// about x^ alone.
void turn_free_parts(Stage& stage);

// Rigid parts (rigid_bodies.hpp) move as they began, by the stage's x0 and v0.
void start_rigid_parts(Stage& stage);
// Has one of them placed by the means of its velocity and its angular momentum before and after the
// stage, as its motion has them now.
void place_by_means(Stage& stage, std::size_t i);
// Puts x0, v0, w, x and b of rigid parts where their motion takes them.
void turn_rigid_parts(Stage& stage);
// Gives rigid parts the motion that is nearest to w, and w that motion. Returns how far at most it
// takes a corner of each from x0 + tau w, cubes of its own.
std::vector<double> take_rigid_motion(Stage& stage);

// What a part's angular momentum is told by: sum m (x_at x w), right where it is what it was
// before, and the torque of the forces from outside.
enum class Balance {
    end,     // x_at = x0 of the stage, but for lifting: that at its end
    middle,  // x_at = x0 + tau v0: that of a step twice as long, whose middle is the stage's end
    linear   // only the linear one
};

// Puts the momenta of free parts right, and of free groups: of sheets that touch each other, and of
// parts that joints link. They began with these x and v.
void balance_free_parts(Stage& stage, const Aligned<double>& before_x,
                        const Aligned<double>& before_v, Balance balance);

// v less the rigid motion of parts that are not held.
Aligned<double> deforming(const Stage& stage, const Aligned<double>& x, const Aligned<double>& v);

}  // namespace physics
