#pragma once

// Contact of lattice bodies: impulses on velocities, one touching point after another, that keep
// points out of each other at the end of a step (projected Gauss-Seidel with Coulomb friction). A
// gap that was there already closes at most to nothing; what was inside comes out by a fifth a
// step.

#include "physics/body/collider_contact.hpp"
#include "physics/lattice/contact_scene.hpp"
#include "physics/lattice/near_along.hpp"
#include "physics/lattice/pair_pushes.hpp"
#include "physics/regions/links.hpp"
#include "physics/state/state.hpp"

#include <algorithm>

namespace physics {

// What any touching point needs, seen from the surface it touches.
struct Push {
    Vec3 normal;
    Vec3 drag = Vec3::Zero();  // N s, across the normal, so far
    double impulse = 0;        // N s, along the normal, so far
    double bias = 0;           // m/s, added to the speed along the normal: their sum closes the gap
                               // by the end of the step
    double mass = 0, mass_across = 0;  // kg, of the point, for impulses along and across the normal
    double friction = 0;
};

// What was inside of another comes out by this share of its depth in a step, not with a jump.
inline constexpr double usual_way_out = 0.2;

// Push::bias of a gap that is expected when the point goes on at `speed` along the normal. What was
// inside already comes out by `share` of it; 0: it stays as deep as it is.
inline double bias_of(double gap, double speed, double dt, double share = usual_way_out)
{
    const double inside = gap - dt * speed;
    return (gap - (1 - share) * std::min(0.0, inside)) / dt - speed;
}

// A point of the skin at a collider.
struct SkinPush : Push {
    std::array<std::uint32_t, 8> corners;
    std::array<double, 8> weight;
    Vec3 surface_velocity;                        // m/s
    std::uint32_t point = none, collider = none;  // `none`: a tear laid the point bare
    double gap = 0;                               // m, where it would be at the end of the step
    double near = 0;                              // m, a gap at which its side is kept
    Vec3 velocity = Vec3::Zero();                 // m/s, with which it would
};

// A rigid ball at a point of the skin, a collider or another ball; the normal points to the ball.
struct BallPush : Push {
    std::uint32_t ball, other = none;    // none: not a ball
    Vec3 arm, other_arm = Vec3::Zero();  // m, from centres to where they touch
    Vec3 surface_velocity = Vec3::Zero();
    std::array<std::uint32_t, 8> corners;
    std::array<double, 8> weight{};  // zeros where it is not the skin
};

std::vector<SkinPush> find_skin_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders);

// Pairs of `side` of different `piece` (numbered from 0) that will be nearer than `distance`, into
// `out`, whose room is used again. With `along` also of one piece, see find_near_pairs().
void find_pair_pushes(const ContactScene& scene, const std::vector<std::uint32_t>& side,
                      const std::vector<std::uint32_t>& piece, double distance, double friction,
                      PairPushes& out, const NearAlong* along = nullptr);

std::vector<BallPush> find_ball_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders);

struct Pushes {
    std::vector<SkinPush> skin;
    PairPushes pairs;
    std::vector<BallPush> balls;
};

// Changes the velocities of particles and balls until no push is left, or `rounds` are over.
void solve_pushes(const ContactScene& scene, Pushes& pushes, int rounds, std::vector<Vec3>& v,
                  std::vector<BallState>& balls);

// The points that are pushed, or are in a collider all the same or near a sheet, when corners go on
// at v for a step of dt seconds; in_order().
std::vector<Grip> holds_of(const std::vector<SkinPush>& pushes, const std::vector<Vec3>& v,
                           double dt);

}  // namespace physics
