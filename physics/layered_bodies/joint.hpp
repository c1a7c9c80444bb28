#pragma once

// Joints between two rigid frames, or of one frame with the world: what a hinge (base.hpp) cannot
// do.
//
//    ball            slider             two axes (Cardan's)
//      a               a ===[b]===        a --+--      axes[0], which a carries
//      (b              along axes[0]          |        and axes[1], which b carries, cross at a
//    all turns                                b        right angle
//
// A joint is a list of rows. Each row has a value q of how b stands to a, m or rad, and a line so
// that
//   dq/dt = along . (v_b - v_a) at the row's arms, or along . (w_b - w_a) where it is angular;
// q is held between two bounds, which are both 0 where the joint does not give way.

#include "geometry/base/no_index.hpp"
#include "geometry/base/vec.hpp"

#include <array>
#include <span>

namespace physics {

using geometry::Mat3;
using geometry::Transform;
using geometry::Vec3;

enum class JointKind : std::uint8_t { ball, slider, two_axis };

struct Joint {
    static constexpr std::uint32_t world = geometry::no_index;  // as frame a: fixed in space

    JointKind kind = JointKind::ball;
    std::uint32_t a = world, b = 0;
    Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();        // m, in both local frames
    Mat3 axes_a = Mat3::Identity(), axes_b = Mat3::Identity();  // columns; the same as drawn
    double lowest = -1e9, highest = 1e9;  // m, of a slider's way along axes[0]
    double cone = 1e9;                    // rad, of a ball: most between a's and b's axes[0]
    double stiffness = 0;  // N/m or N m/rad, towards the pose as drawn, where it gives way
    double damping = 0;    // N s/m or N m s/rad
};

struct JointRow {
    Vec3 along = Vec3::Zero();
    bool angular = false;
    Vec3 arm_a = Vec3::Zero(), arm_b = Vec3::Zero();  // m, from the frames' origins
    double value = 0;                                 // q, m or rad
    double lowest = 0, highest = 0;                   // bounds of q
};

struct JointRows {
    std::array<JointRow, 7> rows;
    std::size_t count = 0;

    JointRow& add() { return rows[count++]; }
    std::span<const JointRow> all() const& { return {rows.data(), count}; }
    std::span<const JointRow> all() const&& = delete;  // they would not outlive it
};

// The rows that hold a joint whose frames are at a and b; for the world a is the pose of the body
// as drawn. How many there are depends on the joint alone.
JointRows joint_rows(const Joint& joint, const Transform& a, const Transform& b);

// The rows along which it gives way, with no bounds: for its stiffness and damping.
JointRows free_rows(const Joint& joint, const Transform& a, const Transform& b);

}  // namespace physics
