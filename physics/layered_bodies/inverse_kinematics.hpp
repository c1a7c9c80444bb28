#pragma once

// Inverse kinematics: the hinge angles that bring points of a figure to where they should be.
//
// Damped least squares: with e the misses of all goals and J = d(points)/d(angles),
//   J = a x (p - o)   for a hinge of axis a through o that carries the point p, else 0
//   dtheta = J^T (J J^T + lambda^2 I)^-1 e
// a Newton step that stays finite where the figure is stretched out.
//   Wampler. Manipulator inverse kinematic solutions based on vector formulations and damped
//   least-squares methods. IEEE Transactions on Systems, Man, and Cybernetics 16(1), 1986.
// A step that would miss by more is not made; lambda is doubled until one misses by less, and
// shrinks after each that is made (Levenberg, Marquardt), so goals out of reach are reached for.
// Angles stay within their hinges' limits: a hinge at its limit that would go beyond is taken out
// of the step.

#include "physics/layered_bodies/base.hpp"

#include <span>
#include <vector>

namespace physics {

struct PoseGoal {
    std::uint32_t frame = 0;     // that carries the point
    Vec3 point = Vec3::Zero();   // m, as the figure is drawn
    Vec3 target = Vec3::Zero();  // m, in the world
};

struct PoseOptions {
    double damping = 0.02;  // lambda at first, of the figure's size
    int most_iterations = 200;
    double tolerance = 1e-6;  // of the figure's size
};

struct SolvedPose {
    std::vector<Transform> frames;  // B, in the world
    std::vector<double> angle;      // one a hinge, rad
    double miss = 0;                // m, of the goal that is missed most
    int iterations = 0;
};

// The figure's size as drawn, m: the diagonal of the box around its frames' origins and the points
// of the goals, and around its hinges where all frames have one origin, as those of still bodies.
double figure_size(const Base& base, std::span<const PoseGoal> goals);

// Frame 0 stays at `root`, which is where the figure as drawn is put; the others hang on it by
// their hinges, as on a tree. `start`: angles to start from (empty: as drawn). Throws
// std::invalid_argument for a frame that no chain of hinges joins to frame 0, hinges that close a
// loop, and goals of frames that are not there or not numbers.
SolvedPose inverse_kinematics(const Base& base, const Transform& root,
                              std::span<const PoseGoal> goals, std::span<const double> start = {},
                              const PoseOptions& options = {});

}  // namespace physics
