#include "physics/bricks/neo_hookean.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Mat3;
using geometry::Vec3;

Mat3 cofactors(const Mat3& f)
{
    Mat3 out;
    out << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
    return out;
}

// F = U diag(s) V^T with rotations U and V, so that one of s is negative where det F is.
struct Singular {
    Mat3 u, v;
    Vec3 s;
};
Singular singular(const Mat3& f)
{
    const Eigen::JacobiSVD<Mat3> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Singular out{svd.matrixU(), svd.matrixV(), svd.singularValues()};
    for (Mat3* m : {&out.u, &out.v}) {
        if (m->determinant() > 0) continue;
        m->col(2) *= -1;
        out.s[2] *= -1;
    }
    return out;
}

// h += value vec(a) vec(a)^T
void add_direction(double value, const Mat3& a, Mat9& h)
{
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> v(a.data());
    h.noalias() += value * v * v.transpose();
}

}  // namespace

NeoHookean::NeoHookean(Lame material)
    : m_(4.0 / 3 * material.mu), l_(material.lambda + 5.0 / 6 * material.mu), a_(1 + 0.75 * m_ / l_)
{}

double NeoHookean::energy(const Mat3& f) const
{
    // Differences from rest, so that small strains have small energies without cancelling.
    const double i = (f - Mat3::Identity()).squaredNorm() + 2 * (f - Mat3::Identity()).trace();
    const double j = f.determinant() - 1;
    return 0.5 * m_ * (i - std::log1p(i / 4)) + 0.5 * l_ * j * j - 0.75 * m_ * j;
}

Mat3 NeoHookean::stress(const Mat3& f) const
{
    const double i = f.squaredNorm();
    return m_ * (1 - 1 / (i + 1)) * f + l_ * (f.determinant() - a_) * cofactors(f);
}

Mat9 NeoHookean::hessian(const Mat3& f, bool positive) const
{
    const auto [u, v, s] = singular(f);
    const double i1 = s.squaredNorm() + 1;
    const double a = m_ * (1 - 1 / i1), b = 2 * m_ / (i1 * i1);
    const double c = l_ * (s.prod() - a_);
    const double least = positive ? 0 : -std::numeric_limits<double>::infinity();
    Mat9 out = Mat9::Zero();
    // Twists and flips in the plane across axis k.
    for (Eigen::Index k = 0; k < 3; ++k) {
        const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;
        const Mat3 ij = u.col(i) * v.col(j).transpose(), ji = u.col(j) * v.col(i).transpose();
        add_direction(std::max(least, a + c * s[k]) / 2, ij - ji, out);
        add_direction(std::max(least, a - c * s[k]) / 2, ij + ji, out);
    }
    // Stretches along the axes.
    const Vec3 g(s[1] * s[2], s[2] * s[0], s[0] * s[1]);
    Mat3 stretch = b * s * s.transpose() + l_ * g * g.transpose();
    for (Eigen::Index k = 0; k < 3; ++k) {
        const Eigen::Index i = (k + 1) % 3, j = (k + 2) % 3;
        stretch(k, k) += a;
        stretch(i, j) += c * s[k];
        stretch(j, i) += c * s[k];
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(stretch);
    for (Eigen::Index k = 0; k < 3; ++k) {
        const Mat3 axes = u * eigen.eigenvectors().col(k).asDiagonal() * v.transpose();
        add_direction(std::max(least, eigen.eigenvalues()[k]), axes, out);
    }
    return out;
}

}  // namespace physics
