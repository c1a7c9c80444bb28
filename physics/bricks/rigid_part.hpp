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

// How a rigid part turns in tau seconds without torque, and its spin then.
struct Turn {
    Mat3 by = Mat3::Identity();
    Vec3 spin = Vec3::Zero();  // rad/s
};

// Its angular momentum stays as it is, to rounding. The turn is that of a ball with the middle one
// of its moments of inertia, which is known, and turns about its shortest and longest axis for what
// is left, composed by a symmetric splitting of fourth order (Yoshida. Construction of higher order
// symplectic integrators. Physics Letters A 1990): exact where two moments are the same, and within
// 1e-6 of its energy else, however long tau is and however thin the part.
Turn turn_freely(const RigidPart& part, double tau);

}  // namespace physics
