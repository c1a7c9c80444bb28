#pragma once

// Contact of a body's surface with colliders: which of its points are inside one, and the forces
// that push them out and rub on them.
//
// A point at p with signed distance g(p) < 0 from a collider, normal n, is pushed out by the force
//   N n,  N = k (-g),   k = min(10 E A / h, 1000 M g / h) + m / dt^2
// as by a layer of ten times the body's own material, one cube thick, over the area A that the
// point stands for (so that a resting body sinks in by a tenth of its own squash, however fine the
// mesh), but no stiffer than bears the whole body of mass M within a thousandth of a cube, for what
// is stiffer than need be is hard to solve; and enough to stop the point's own mass m within a
// step. Friction is Coulomb's with a creep velocity e far below what can be seen:
//   -c v_t,   c = mu N / max(|v_t|, e),   e = h / 10000 dt
// where N and |v_t| are taken from the last iterate. Both enter the implicit step with what stands
// for their derivatives, k n n^T and
//   c (I - n n^T - a t t^T),   t = v_t / |v_t| where that is above e.
// With a = 0 no step reverses a slip, but one that comes to rest does so a part at a time; a = 1 is
// the derivative with N as it is, and gets there at once or goes too far.

#include "physics/body/contact_surface.hpp"
#include "physics/state/loads.hpp"

#include <span>
#include <string>
#include <vector>

namespace physics {

// A collider at one instant inside a frame.
struct PosedCollider {
    Collider::Kind kind = Collider::Kind::plane;
    Vec3 half_size = Vec3::Zero();
    double radius = 0;
    double thickness = 0;
    double friction = 0;
    geometry::Transform pose, inverse;               // local to world and back
    geometry::Transform end, start;                  // at both ends of the frame
    double frame = 0;                                // s
    double behind = 0;                               // share of the frame still to come
    const geometry::TriMesh* mesh = nullptr;         // at the end of the frame
    const geometry::TriMesh* mesh_before = nullptr;  // at its start
    std::shared_ptr<const geometry::TriangleBvh> tree;
    geometry::Box mesh_bounds;
    double reach = 0;  // m, how deep below an open mesh still counts as inside
};

// `share` 0..1 of the frame of `frame` seconds has gone by. `h` (m) is the scale of the body.
PosedCollider pose_collider(const Collider& collider, double share, double frame, double h);

// Where a point stands to a collider.
struct Touch {
    double gap = std::numeric_limits<double>::infinity();  // m, negative inside
    Vec3 normal = Vec3::UnitY();                           // out of the collider
    Vec3 velocity = Vec3::Zero();                          // m/s, of the collider's surface there
};
// A mesh answers only for points inside.
Touch touch(const PosedCollider& collider, const Vec3& p);

// The same for a point that has come to `to` at velocity v (m/s) within dt seconds: where it went
// through the nearest wall, or past the middle of it, it touches the side that it came from.
Touch touch(const PosedCollider& collider, const Vec3& to, const Vec3& v, double dt);

// Whether points within `radius` of p, none faster than `speed`, may touch after dt seconds: a
// distance changes no faster than a place.
bool may_touch(const PosedCollider& collider, const Vec3& p, double radius, double speed,
               double dt);

// A sentence for each collider that holds a corner of the cubes at rest more than a cube deep:
// contact will throw it out in the first steps. Corners that are pinned are left out, as a foot in
// the ground is. Of many corners some twenty thousand are looked at.
std::vector<std::string> buried(const geometry::Cubes& cubes, const Pins& pins,
                                std::span<const Collider> colliders);

// A point of the surface that is inside a collider.
struct ColliderContact {
    std::array<std::uint32_t, 8> corners;  // slots
    std::array<float, 8> weight;
    Vec3 force;                       // N, on the point
    std::array<double, 6> stiffness;  // N/m, xx xy xz yy yz zz: minus its derivative by position
    std::array<double, 6> drag;       // N s/m, the same by velocity
    double energy;                    // J, of the layer that is pressed together
};

// All contacts of points at x moving at v (four numbers a slot), in a step of dt seconds. `tangent`
// is the a above, 0 .. 1.
std::vector<ColliderContact> find_collider_contacts(const ContactSurface& surface, double h,
                                                    const double* x, const double* v,
                                                    const std::vector<PosedCollider>& colliders,
                                                    double dt, double tangent);

}  // namespace physics
