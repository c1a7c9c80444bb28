#pragma once

// A mass-spring net as the base structure of a layer: segments and triangles between masses.
//
//   m0 o=====o m1     Each point of a skeleton is a mass, and points at one place are the same one.
//       \   /         A segment or triangle has a frame of its own, which its masses carry: between
//        \ /          frames the skin is one, as the skeletons share their masses.
//      m2 o
//
// Frames of a net: its masses, which are particles, and after them a frame for each segment and
// triangle, drawn around the middle of its n masses. Masses i at x_i and v_i, p_i where they are
// drawn in that frame:
//   x = sum x_i / n        A = sum (x_i - x) p_i^T = R S
//   velocity of x = sum v_i / n
//   spin = Q sum (R p_i) x v_i,   Q = R (tr(S) I - S)^-1 R^T
// as cube_base.hpp has it for cubes; the skeleton's points lie at R^T (x_i - x), so that it
// stretches with its masses. What the frame feels comes to the masses by the transpose, which keeps
// force and torque; but no mass can take the torque about a segment's own axis, and a segment turns
// by the shortest way, without a twist. What presses a frame in its own line or plane comes to its
// masses in equal parts.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, V: networks of masses and springs.

#include "physics/layered_bodies/layered.hpp"

namespace physics {

// Joins the masses of a net along its segments and the sides of its triangles by springs at rest.
// Throws std::invalid_argument where the base is no net.
void add_spring_skeletons(Base& base, double stiffness, double damping);

// The masses that carry frame f of a net, one of its last.
std::span<const std::uint32_t> masses_of(const Base& base, std::size_t f);

// How masses at `position` carry frame f of a net, which stood as `before` turns it.
struct NetHold {
    Vec3 middle = Vec3::Zero();
    Mat3 turn = Mat3::Identity();
    std::vector<Eigen::Matrix<double, 6, 3>> by;  // a mass's velocity to its part of the twist
};
NetHold net_hold(const Base& base, std::size_t f, std::span<const Vec3> position,
                 const Mat3& before);

// Brings the carried frames of a net to where its masses are. Does nothing for other bodies.
void follow_masses(const LayeredBody& body, LayeredState& state);

// Stretches the skeletons of a net, and their samples, as its masses are now.
void stretch_net(const LayeredBody& body, const LayeredState& state, ImplicitLayer& layer,
                 SurfaceSamples& samples);

}  // namespace physics
