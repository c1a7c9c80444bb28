#pragma once

// A part of a body as a rigid body, and how it turns within a stage of a time step.

#include "geometry/base/vec.hpp"

namespace physics {

using geometry::Mat3;
using geometry::Vec3;

struct RigidPart {
    double mass = 0;               // kg
    Vec3 centre = Vec3::Zero();    // m
    Vec3 velocity = Vec3::Zero();  // m/s
    Vec3 spin = Vec3::Zero();      // rad/s
    Mat3 inertia = Mat3::Zero();   // kg m^2, about the centre
    Vec3 momentum = Vec3::Zero();  // N m s, about the centre
};

// b with inertia b = l, as far as it turns anything: a part on a line has no inertia about it.
Vec3 spin_of(const Mat3& inertia, const Vec3& l);

// How a rigid part turns in tau seconds, and its spin then: the midpoint rule on rotations, with
// its angular momentum as it is (Simo, Wong. Unconditionally stable algorithms for rigid body
// dynamics. IJNME 1991), by fixed-point iterations that gain a digit each while it turns by a tenth
// of a radian.
struct Turn {
    Mat3 by = Mat3::Identity();
    Vec3 spin = Vec3::Zero();  // rad/s
};
Turn turn_freely(const RigidPart& part, double tau);

// The same in as many turns as it takes to keep each below half a radian.
Turn turn_far(const RigidPart& part, double tau);

}  // namespace physics
