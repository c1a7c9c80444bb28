#pragma once

// Loads that depend on where the body is: pressure on a surface that it carries, torques, and
// forces that turn with what they act on (follower loads). Steps take them as they are where a
// stage is about to end (step_newton.cpp): their derivative is not symmetric, and in no matrix
// here.
//
// Pressure P pushes on nodes i of a face x(u, v) = sum_i phi_i x_i, phi quadratic, by
//   f_i = -P integral of phi_i (x_u cross x_v) du dv
// which is -P times the derivative of the volume that the faces enclose. That does not change where
// they move or turn as one, so the forces on a closed surface and their torques sum to 0, however
// it is deformed.
//
// A torque T on a region of shares s_k, which sum to 1, turns it about its centre c = sum s_k x_k:
//   f_k = s_k (a cross (x_k - c)),   (sum s_k ((r . r) I - r r^T)) a = T,   r = x_k - c
//
// What follows turns by the rotation R of the region, that of the polar decomposition of
//   sum_k s_k (x_k - c) (X_k - C)^T,   X the rest shape

#include "physics/body/force_shares.hpp"

#include <span>

namespace physics {

// As they are kept for a frame. The forces must outlive it.
struct FollowingForces {
    struct Region {
        const Force* force;
        ForceShares shares;
    };
    std::vector<Region> regions;          // of torques and point forces that follow
    std::vector<const Force*> pressures;  // that are not 0

    bool empty() const { return regions.empty() && pressures.empty(); }
};

// Whether a force depends on where the body is, other than on its velocity.
bool follows(const Force& force);

// Throws std::invalid_argument when the region of a torque or of a force that follows is a point or
// a line, which cannot be turned, or a surface has corners that the body does not.
FollowingForces following_forces(const CornerBody& body, std::span<const Force> forces);

// Adds them at x to f. N, numbers.
void add_following_forces(const FollowingForces& forces, const CornerBody& body, const double* x,
                          Aligned<double>& f);

// Throws std::invalid_argument, with what to do, where one of the forces follows: `who` cannot.
void require_no_following(std::span<const Force> forces, const std::string& who);

}  // namespace physics
