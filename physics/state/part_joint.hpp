#pragma once

// Joints: places where two parts of a simulation are kept together.
//
//   cubes of one model, or of two -> the part of each that is nearest -> points that both carry
//     -> numbered among all that are simulated -> springs of a step (physics/bricks/joints.hpp)
//
// A point p of a joint is carried by a cube of each part, with the trilinear weights w that it has
// in them at rest: its gap is sum w_a x_a - sum w_b x_b. One point is a ball joint, two a hinge
// about the line through them, and more that lie in no line a weld. Glue has one for each corner of
// one part that lies in cubes of the other (glue.hpp).

#include "geometry/cubes/cubes.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace physics {

enum class PartJointKind { ball, hinge, weld, glue };

struct PartJointSettings {
    PartJointKind kind = PartJointKind::ball;
    Vec3 position{0, 0, 0};  // m, in the rest shape; of all but glue
    Vec3 axis{0, 1, 0};      // of a hinge; any length but 0
    double size = 0;  // m, length of a hinge, width of a weld; 0: four edges of the smaller cubes
    // m, to the nearest cube of either part; 0: an edge of its cubes, of glue a quarter of one
    double reach = 0;
};

// What may be wrong with a joint.
struct JointDoubts {
    std::size_t others = 0;            // parts besides that hold the position too
    std::array<double, 2> outside{};   // edges, by which its points lie outside of each part
    std::size_t loose = 0, parts = 0;  // of glue: parts that are glued to no other, and all parts

    // Beyond two edges, corners of the nearest cube would have weights above three: the cube bends
    // and the part hangs loose. The usual size stays within them.
    bool too_wide(std::size_t side) const { return outside[side] > 2 + 1e-9; }
};

// The joint of the nearest part of each of two models, or of the two nearest parts of one; glue of
// all parts of both, or of one, that touch. A part is what cubes are that hang together by corners.
// Throws std::invalid_argument, with what to do, where a part is out of reach, where there is no
// second one, for cubes of a plane or a sheet, and for an axis or a position that is not finite or
// zero.
PartJoint make_joint(std::span<const std::shared_ptr<const geometry::Cubes>> cubes,
                     const PartJointSettings& settings, JointDoubts* doubts = nullptr);

// The points of a joint, with the corners of all models that are simulated: `models`, or the cubes
// of the only one. Throws std::invalid_argument where it is of other cubes.
std::vector<JointPoint> points_of_all(const PartJoint& joint,
                                      std::span<const std::shared_ptr<const geometry::Cubes>> cubes,
                                      const std::vector<StateModel>& models);

}  // namespace physics
