#include "physics/bricks/rigid_part.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace physics {

Vec3 spin_of(const Mat3& inertia, const Vec3& l)
{
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
    const Vec3& value = solver.eigenvalues();
    Vec3 out = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
        if (!(value[i] > 1e-9 * value[2])) continue;
        const Vec3 axis = solver.eigenvectors().col(i);
        out += axis * (axis.dot(l) / value[i]);
    }
    return out;
}

namespace {

Mat3 turned_by(const Vec3& spin, double seconds)
{
    const double rate = spin.norm();
    if (!(rate > 0)) return Mat3::Identity();
    return Eigen::AngleAxisd(rate * seconds, spin / rate).toRotationMatrix();
}

}  // namespace

Turn turn_freely(const RigidPart& part, double tau)
{
    constexpr int iterations = 12;
    const auto spin_after = [&](const Mat3& by) {
        return spin_of(by * part.inertia * by.transpose(), part.momentum);
    };
    Vec3 middle = part.spin;
    for (int i = 0; i < iterations; ++i) middle = spin_after(turned_by(middle, 0.5 * tau));
    const Mat3 by = turned_by(middle, tau);
    return {by, spin_after(by)};
}

Turn turn_far(const RigidPart& part, double tau)
{
    constexpr double far = 0.5, most = 1000;  // rad, turns
    const double way = part.spin.norm() * tau;
    if (!std::isfinite(way)) return {Mat3::Identity(), part.spin};
    const double turns = std::min(most, std::ceil(way / far));
    if (!(turns > 1)) return turn_freely(part, tau);
    RigidPart now = part;
    Turn out;
    for (int i = 0; i < static_cast<int>(turns); ++i) {
        const Turn turn = turn_freely(now, tau / turns);
        now.inertia = turn.by * now.inertia * turn.by.transpose();
        now.spin = turn.spin;
        out = {turn.by * out.by, turn.spin};
    }
    return out;
}

}  // namespace physics
