#pragma once

// Pins that hold corners of rigid parts: one corner of a rigid part cannot move on its own, so that
// a spring holds it, as springs hold material (hold_matter.hpp). Two corners make a hinge, three
// hold or drive the part.

#include "physics/bricks/bricks_body.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/measure.hpp"

namespace physics {

// The same pins, with springs at corners of rigid parts. In steps of dt seconds they give way by
// less than a 10,000th of the way that the forces on the part would take it in a step; on one that
// joints link to heavy parts, a 1,000th. `joints` are between corners of this body.
Pins with_rigid_pins(const BricksBody& body, const Pins& pins, double dt,
                     std::span<const JointPoint> joints);

// What those springs exert on the body at the corners of `pins`, which are no reactions: a state
// has them last among the forces of springs that hold material.
PinForce rigid_pin_force(const State& state, const Pins& pins, const Vec3& point);

}  // namespace physics
