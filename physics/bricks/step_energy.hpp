#pragma once

// The energy that steps of the midpoint rule may have. That rule damps nothing and keeps both
// momenta, but in stiff bodies that turn it gains energy without end (Simo, Tarnow. The discrete
// energy-momentum method. ZAMP 1992). Where the energy is known, which is where nothing but
// gravity, forces that do not change within a step, pins that stay and contact act, its error is
// therefore taken out of the velocities with which parts deform, as v = rigid + share * (v -
// rigid). Momenta stay what they are. A step that gained more than that can undo is not to be used.
//
// What is touched takes energy by friction and by what is pressed together: after a step in which
// something is, what the body has less than was due is due no more. A collider that moves may give
// it any.

#include "physics/bricks/stage.hpp"

namespace physics {

struct EnergyAccount {
    bool known = false;
    double due = 0;   // J
    double owed = 0;  // J, more than was due after the last step: the next ones take it out
};

// Whether it is known in this frame, and what it is at x, v, less what is owed from before.
EnergyAccount open_account(Stage& stage, const Aligned<double>& x, const Aligned<double>& v,
                           double owed = 0);

// Takes forces as they are at a share of the frame. What they change at x is due.
void take_forces(EnergyAccount& account, StepFrame& frame, const Aligned<double>& x, double share);

// Takes off what damping takes over `seconds` at the velocities of the stage as it is solved.
void charge_damping(EnergyAccount& account, Stage& stage, double seconds);

// Gives v, at x, the energy due, as far as it can, after a step that the stage took: where little
// deforms, what is left is owed. False: more than a tenth of the energy of deformation, and more
// than 1e-4 of that of motion, is too much and stays.
bool settle(EnergyAccount& account, Stage& stage, const Aligned<double>& x, Aligned<double>& v);

// What parts that touch each other, or colliders, gained in a step from the energy of (x, v) to
// that of (after_x, after_v), J: planes that stay as they were found push what turns on through
// them, and forces that are linear about where the step began stretch what turns. 0 where nothing
// is pressed (of sheets, by another part), where the gain is within a fiftieth of the energy that
// it has before or after, and where it is not known, as where a collider or a pin moves.
double gained_by_touching(Stage& stage, const Aligned<double>& x, const Aligned<double>& v,
                          const Aligned<double>& after_x, const Aligned<double>& after_v);

// Takes it off the motion of the parts that press each other, about the centre of mass of those
// that hang together by that; where a pin holds one of them, off all of their motion. False: there
// is less.
bool take_off(const Stage& stage, double gained, Aligned<double>& v);

}  // namespace physics
