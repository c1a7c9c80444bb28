#pragma once

// Contact of lattice bodies: impulses on velocities, one touching point after another, that keep
// points out of each other at the end of a step (projected Gauss-Seidel with Coulomb friction). A
// gap that was there already closes at most to nothing; what was inside comes out by a fifth a
// step.

#include "physics/contact.hpp"
#include "physics/corner_body.hpp"
#include "physics/lattice_regions.hpp"
#include "physics/state.hpp"

#include <span>

namespace physics {

// What any touching point needs.
struct Push {
    Vec3 normal, surface_velocity = Vec3::Zero();
    double gap = 0;       // m, at the end of the step if nothing else happens, less what may remain
    double approach = 0;  // m/s, of the point along the normal when the gap was looked at
    double inverse = 0;   // 1/kg, of the point
    double inverse_across = 0;  // 1/kg, the same for impulses across the normal
    double friction = 0;
    double impulse = 0;  // N s, along the normal
    Vec3 drag = Vec3::Zero();
};

// A point of the skin at a collider.
struct SkinPush : Push {
    std::array<std::uint32_t, 8> corners;
    std::array<double, 8> weight;
};

// Two particles of bodies that are not linked; the normal points from b to a.
struct PairPush : Push {
    std::uint32_t a, b;
    double inverse_a, inverse_b;  // 1/kg
};

// A rigid ball at a point of the skin, a collider or another ball; the normal points to the ball.
struct BallPush : Push {
    std::uint32_t ball, other = none;    // none: not a ball
    Vec3 arm, other_arm = Vec3::Zero();  // m, from centres to where they touch
    std::array<std::uint32_t, 8> corners;
    std::array<double, 8> weight{};  // zeros where it is not the skin
};

// Who is in contact, and when.
struct ContactScene {
    const CornerBody& body;
    const State& state;
    const std::vector<std::uint8_t>& pinned;  // by corner; empty without pins
    double dt;                                // s, the step
    std::span<const Ball> balls = {};

    double inverse_mass(std::uint32_t i) const
    {
        return !pinned.empty() && pinned[i] ? 0 : 1 / body.mass[i];
    }
};

std::vector<SkinPush> find_skin_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders);

// Pairs of `side` of different `piece` that will be nearer than `distance`.
std::vector<PairPush> find_pair_pushes(const ContactScene& scene,
                                       const std::vector<std::uint32_t>& side,
                                       const std::vector<std::uint32_t>& piece, double distance,
                                       double friction);

std::vector<BallPush> find_ball_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders);

struct Pushes {
    std::vector<SkinPush> skin;
    std::vector<PairPush> pairs;
    std::vector<BallPush> balls;
};

// Changes the velocities of particles and balls until no push is left, or `rounds` are over.
void solve_pushes(const ContactScene& scene, Pushes& pushes, int rounds, std::vector<Vec3>& v,
                  std::vector<BallState>& balls);

}  // namespace physics
