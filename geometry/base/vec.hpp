#pragma once

// The few linear-algebra names that every kernel speaks. SI units, y up, right-handed.

#include <Eigen/Dense>

#include <array>
#include <cstdint>

namespace geometry {

using Vec2f = Eigen::Vector2f;
using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;
using Vec3i = Eigen::Vector3i;
using Mat3 = Eigen::Matrix3d;
using Mat3f = Eigen::Matrix3f;
using Transform = Eigen::Affine3d;  // maps local to world

using Triangle = std::array<std::uint32_t, 3>;

// Closed box, empty when any lo > hi. Metres.
struct Box {
    Vec3 lo = Vec3::Constant(std::numeric_limits<double>::infinity());
    Vec3 hi = Vec3::Constant(-std::numeric_limits<double>::infinity());

    bool empty() const { return (lo.array() > hi.array()).any(); }
    void add(const Vec3& p)
    {
        lo = lo.cwiseMin(p);
        hi = hi.cwiseMax(p);
    }
    void add(const Box& b)
    {
        lo = lo.cwiseMin(b.lo);
        hi = hi.cwiseMax(b.hi);
    }
    Vec3 size() const { return empty() ? Vec3(Vec3::Zero()) : Vec3(hi - lo); }
    Vec3 centre() const { return 0.5 * (lo + hi); }
    double diagonal() const { return size().norm(); }
};

}  // namespace geometry
