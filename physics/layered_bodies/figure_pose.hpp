#pragma once

// Forward kinematics: where the frames of a figure are when its hinges and joints stand as told.
//
//    frame 0 at the root --hinge 0--> frame 1 --joint 0--> frame 2 ...     as on a tree

#include "physics/layered_bodies/base.hpp"

#include <span>
#include <vector>

namespace physics {

// How a joint stands; what its kind has no use for is not looked at.
struct JointPose {
    Vec3 turn = Vec3::Zero();      // rad, of a ball: about x, then y, then z of a's frame as drawn
    double first = 0, second = 0;  // rad, of two axes; m, of a slider: first
};

// Frame 0 stays at `root`, which is where the figure as drawn is put. `angle`: one a hinge, rad;
// `pose`: one a joint; of both, what is left out is 0. Angles are not held to limits. Joints with
// the world are not looked at. Throws std::invalid_argument for a frame that nothing joins to frame
// 0, and for joints that close a loop.
std::vector<Transform> figure_pose(const Base& base, const Transform& root,
                                   std::span<const double> angle, std::span<const JointPose> pose);

}  // namespace physics
