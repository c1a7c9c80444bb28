#pragma once

// Contact of a body's surface with colliders: which of its points are inside one, and the forces
// that push them out and rub on them.
// The law of these forces stands in point_contact.hpp.

#include "physics/body/corner_body.hpp"
#include "physics/body/plane_touch.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state_models.hpp"

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
    double friction = 0, bounce = 0;
    geometry::Transform pose, inverse;               // local to world and back
    Vec3 slides = Vec3::Zero();                      // m/s, its origin
    Vec3 turns = Vec3::Zero();                       // rad/s, about that
    double frame = 0;                                // s
    double behind = 0;                               // share of the frame still to come
    const geometry::TriMesh* mesh = nullptr;         // at the end of the frame
    const geometry::TriMesh* mesh_before = nullptr;  // at its start
    std::shared_ptr<const geometry::TriangleBvh> tree;
    std::shared_ptr<const KeptFeatures> features;  // of a mesh that stays; null: none are kept
    geometry::Box mesh_bounds;
    double longest = 0;  // m, way of a vertex within the frame
    double reach = 0;    // m, how deep below an open mesh still counts as inside
    bool sheet = false;  // nothing is inside: points touch the side that they come from
    bool first = false;  // in this frame, but for what starts less than `reach` behind its front
    ColliderSize grows;  // m/s
};

// `share` 0..1 of the frame of `frame` seconds has gone by. `h` (m) is the scale of the body, and
// `thickest` (m) is how far it lies before its points at most (ContactSurface). `first`: the frame
// is the first of a shot, where things that are to stand on a sheet may lie a bit below.
PosedCollider pose_collider(const Collider& collider, double share, double frame, double h,
                            bool first = false, double thickest = 0);

// How far behind a face of a sheet a point may come that went over a crease, m; 0 for others. Its
// side is kept for as long as it is no farther away.
double crease_of(const PosedCollider& collider);

// Where a point stands to a collider.
struct Touch {
    double gap = std::numeric_limits<double>::infinity();  // m, negative inside
    Vec3 normal = Vec3::UnitY();                           // out of the collider
    Vec3 velocity = Vec3::Zero();                          // m/s, of the collider's surface there
    Vec3 chord = Vec3::Zero();  // m, of a mesh that moves: what it goes within the frame there,
    Vec3 turn = Vec3::Zero();   // rad, and its triangle turns
};
// The touch with the surface whose normal is another one.
void turn_touch(const PosedCollider& collider, const Vec3& normal, Touch& touch);

// A mesh answers only for points inside.
Touch touch(const PosedCollider& collider, const Vec3& p);

// The same for a point that has come to `to` at velocity v (m/s) within dt seconds: where it went
// through the nearest wall, or past the middle of it, it touches the side that it came from. What
// `held` it at the start, if any, tells on which side and how deep it was.
Touch touch(const PosedCollider& collider, const Vec3& to, const Vec3& v, double dt,
            const Grip* held = nullptr);

// The mean velocity (m/s) within the last dt seconds of what was at a point's place when they
// began: what the collider carries ends up on the arc that it goes along. Along the normal it is
// that of the touch of the point, now at `to` with velocity v.
Vec3 carrying(const PosedCollider& collider, const Touch& touch, const Vec3& to, const Vec3& v,
              double dt);

// Whether points within `radius` of p, none faster than `speed`, may touch after dt seconds: a
// distance changes no faster than a place.
bool may_touch(const PosedCollider& collider, const Vec3& p, double radius, double speed,
               double dt);

// A sentence for each collider that holds a corner of the cubes at rest more than a cube deep:
// contact will push it out. Corners that are pinned are left out, as a foot in
// the ground is. Of many corners some twenty thousand are looked at. Pins count the corners of
// all models, one after another. Where there are surfaces, one for each model, as much of them is
// so deep too: cubes at a slope reach into what their surface is clear of.
using SurfacesOfModels = std::span<const std::shared_ptr<const geometry::TriMesh>>;
std::vector<std::string> buried(ModelsOfState models, const Pins& pins,
                                std::span<const Collider> colliders,
                                SurfacesOfModels surfaces = {});

}  // namespace physics
