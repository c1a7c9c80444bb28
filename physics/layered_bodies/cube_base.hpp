#pragma once

// Squashing cubes as the base structure of a layer: they carry its frames, and what the frames feel
// is handed to their corners.
//
// A frame's place X, the middle of what its skeletons' samples start from, moves as the cubes
// around it do, and it turns by the rotation nearest to their deformation gradient there, corners a
// at x_a and v_a:
//   x = sum w_a x_a        F = sum x_a g_a^T = R S
//   velocity of x = sum w_a v_a
//   spin = Q sum (R g_a) x v_a,   Q = R (tr(S) I - S)^-1 R^T
// the last because R^T dF less its transpose is [(tr(S) I - S) R^T spin]x. The frame follows its
// corners by spin and velocity, J v; a wrench on it comes to the corners by J^T. Since
//   sum w_a = 1,   sum g_a = 0,   sum X_a g_a^T = I
// a rigid motion of the corners is the frame's, and J^T keeps force and torque to round-off.

#include "physics/bricks/bricks.hpp"
#include "physics/layered_bodies/carry_frames.hpp"

#include <span>
#include <vector>

namespace physics {

using Vec6 = Eigen::Matrix<double, 6, 1>;  // a twist: velocity, spin; or a wrench
using Mat6 = Eigen::Matrix<double, 6, 6>;

// How corners follow a frame and it them, where they are now.
struct FrameHold {
    Transform moved = Transform::Identity();      // from where the frame is at rest
    std::vector<Eigen::Matrix<double, 6, 3>> by;  // J: a corner's velocity to its part of the twist
};

// Immutable; stored as what it was made from.
class CubeBase {
public:
    struct Source {
        geometry::Cubes cubes;
        BrickOptions options;
        CarriedFrames frames;
    };
    CubeBase() = default;
    // Throws std::invalid_argument when the cubes are no solid body.
    explicit CubeBase(Source source);
    const Source& source() const { return source_; }
    const BricksBody& bricks() const { return bricks_; }

    // The corners that carry frame f.
    std::span<const std::uint32_t> corners(std::size_t f) const { return carried_[f].corner; }
    // kg, of what moves with frame f at once: 1 / sum w_a^2 / m_a.
    double mass(std::size_t f) const { return carried_[f].mass; }
    // Where corners at x (K, m) carry frame f, which is drawn at `rest`. Cubes that are squashed
    // flat turn it less than their corners would, instead of without bound.
    FrameHold hold(std::size_t f, const Transform& rest, std::span<const Vec3> x) const;

    std::size_t bytes() const;

private:
    struct Carried {
        std::vector<std::uint32_t> corner;
        std::vector<double> weight;  // w_a
        std::vector<Vec3> slope;     // g_a, 1/m
        Vec3 centre = Vec3::Zero();  // X, m
        double mass = 0;
    };

    Source source_;
    BricksBody bricks_;
    std::vector<Carried> carried_;
};

}  // namespace physics
