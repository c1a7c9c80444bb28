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

// A part that turns freely, in its own axes.
class FreeTurn {
public:
    FreeTurn(const Mat3& axes, const Vec3& inertia, const Vec3& momentum)
        : axes_(axes), momentum_(axes.transpose() * momentum)
    {
        for (const Eigen::Index i : {shortest, longest}) {
            // What is on a line has no inertia about it, and no momentum.
            const bool turns = inertia[i] > on_a_line * inertia[longest];
            excess_[i] = turns ? 1 / inertia[i] - 1 / inertia[1] : 0;
        }
    }

    // rad/s, the most that the part may ever turn by beside a ball.
    double fastest(const Vec3& inertia) const
    {
        const double energy = momentum_.squaredNorm() / inertia[1] +
                              excess_[shortest] * momentum_[shortest] * momentum_[shortest] +
                              excess_[longest] * momentum_[longest] * momentum_[longest];
        double out = 0;  // |l_i| <= sqrt(2 E I_i)
        for (const Eigen::Index i : {shortest, longest}) {
            const double square = std::max(0.0, energy * inertia[i]);
            out = std::max(out, std::abs(excess_[i]) * std::sqrt(square));
        }
        return out;
    }

    // A step of second order for what sets it apart from a ball.
    void step(double tau)
    {
        turn(longest, 0.5 * tau);
        turn(shortest, tau);
        turn(longest, 0.5 * tau);
    }

    const Mat3& axes() const { return axes_; }

    static constexpr double on_a_line = 1e-9;  // of the largest moment

private:
    static constexpr Eigen::Index shortest = 0, longest = 2;  // by their moments

    void turn(Eigen::Index axis, double tau)
    {
        const double angle = tau * excess_[axis] * momentum_[axis];
        const Mat3 by = Eigen::AngleAxisd(angle, Vec3::Unit(axis)).toRotationMatrix();
        axes_ = axes_ * by;
        momentum_ = by.transpose() * momentum_;
    }

    Mat3 axes_;
    Vec3 momentum_;
    Vec3 excess_ = Vec3::Zero();  // 1/(kg m^2)
};

}  // namespace

Turn turn_freely(const RigidPart& part, double tau)
{
    constexpr double far = 0.1, most = 1000;  // rad, steps
    if (!part.spin.allFinite() || !part.inertia.allFinite() || !part.momentum.allFinite()) {
        return {Mat3::Identity(), part.spin};
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(part.inertia);
    const Vec3& inertia = solver.eigenvalues();
    if (!(inertia[1] > FreeTurn::on_a_line * inertia[2])) return {Mat3::Identity(), Vec3::Zero()};
    Mat3 begin = solver.eigenvectors();
    if (begin.determinant() < 0) begin.col(0) = -begin.col(0);
    FreeTurn own(begin, inertia, part.momentum);
    const double way = std::abs(tau) * own.fastest(inertia);
    const int steps = static_cast<int>(std::min(most, std::ceil(way / far)));
    const double outer = 1 / (2 - std::cbrt(2.0)), inner = 1 - 2 * outer;
    for (int i = 0; i < steps; ++i) {
        for (const double share : {outer, inner, outer}) own.step(share * tau / steps);
    }
    const double about = part.momentum.norm() * tau / inertia[1];
    const Mat3 as_ball =
        about == 0 ? Mat3(Mat3::Identity())
                   : Eigen::AngleAxisd(about, part.momentum.normalized()).toRotationMatrix();
    const Mat3 by = as_ball * own.axes() * begin.transpose();
    return {by, spin_of(by * part.inertia * by.transpose(), part.momentum)};
}

}  // namespace physics
