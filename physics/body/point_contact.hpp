#pragma once

// A point of a body's surface that touches something, and the forces there.
//
// A point at p with signed distance g(p) < 0 from what it touches, normal n, is pushed out by the
// force
//   N n,  N = k (-g),   k = min(10 E A / h, 1000 M g / h) + m / dt^2
// as by a layer of ten times the body's own material, one cube thick, over the area A that the
// point stands for (so that a body that comes to rest sinks in by a tenth of its own squash,
// however fine the mesh), but no stiffer than bears the whole body of mass M within a thousandth of
// a cube, for what is stiffer than need be is hard to solve; and enough to stop the point's own
// mass m within a step (k grows for points that come fast, are deep, or rest: plane_touch.hpp).
// Friction is Coulomb's, and viscous below a velocity e, which plane_touch.hpp makes a spring of:
//   -c v_t,   c = mu N / max(|v_t|, e)
// where N and |v_t| are taken from the last iterate. Both enter the implicit step with what stands
// for their derivatives, k n n^T and
//   c (I - n n^T - a t t^T),   t = v_t / |v_t| where that is above e.
// With a = 0 no step reverses a slip, but one that comes to rest does so a part at a time; a = 1 is
// the derivative with N as it is, and gets there at once or goes too far.

#include "geometry/base/vec.hpp"

#include <array>

namespace physics {

using geometry::Vec3;

// Its place is the sum of weight times place over the first eight corners, which carry the force;
// what it touches carries the opposite. Where that is a cube of another part, or a triangle or edge
// of a sheet, its corners follow with weights below 0: the sum is then how far the point is from
// the matter there, and the weights hand the opposite force to it at the same place, which keeps
// momentum and angular momentum.
struct PointContact {
    static constexpr std::size_t most = 16;

    std::array<std::uint32_t, most> corners{};  // slots
    std::array<float, most> weight{};
    std::uint32_t count = 8;            // of corners: 8, of sheets 12, of parts 16
    Vec3 force = Vec3::Zero();          // N, on the point
    std::array<double, 6> stiffness{};  // N/m, xx xy xz yy yz zz: minus its derivative by position
    std::array<double, 6> drag{};       // N s/m, the same by velocity
    double energy = 0;                  // J, of the layer that is pressed together
};

// Where a point stands to what it touches.
struct Gap {
    double size = 0;               // m, below 0 inside
    Vec3 normal = Vec3::UnitY();   // out of what it touches
    Vec3 velocity = Vec3::Zero();  // m/s, of the point relative to it
    double load = -1;              // N, that friction is a share of; below 0: the push of the gap
};

// How contacts of one step are pressed and rubbed.
struct ContactLaw {
    double friction = 0;  // mu
    double creep = 0;     // m/s, e
    double tangent = 0;   // a, 0 .. 1
};

// Forces and derivatives at a gap below 0 with `stiffness` k (N/m). Corners are left to the caller.
PointContact contact_at(const Gap& gap, double stiffness, const ContactLaw& law);

}  // namespace physics
