#include "physics/bricks/brick_element.hpp"

#include "geometry/base/random.hpp"
#include "physics/body/stiffness.hpp"

#include <gtest/gtest.h>

using namespace physics;
using geometry::Mat3;
using geometry::Vec3;

namespace {

Vec3 sign(unsigned a)
{
    return Vec3(a & 1 ? 1 : -1, a & 2 ? 1 : -1, a & 4 ? 1 : -1);
}

// K by Gauss points and, for the incompatible element, numerical condensation of the nine bubbles
// 1 - xi_d^2 in each direction.
BrickMatrix by_quadrature(double h, Lame material, BrickElement element)
{
    const auto [lambda, mu] = material;
    Eigen::Matrix<double, 33, 33> k = Eigen::Matrix<double, 33, 33>::Zero();
    const double g = 1 / std::sqrt(3.0);
    for (unsigned point = 0; point < 8; ++point) {
        const Vec3 xi = g * sign(point);
        Eigen::Matrix<double, 3, 11> slope;  // of each shape function, 1/m
        for (unsigned a = 0; a < 8; ++a) {
            const Vec3 s = sign(a), t = Vec3::Ones() + s.cwiseProduct(xi);
            slope.col(a) = Vec3(s[0] * t[1] * t[2], s[1] * t[0] * t[2], s[2] * t[0] * t[1]) / 8;
        }
        for (int d = 0; d < 3; ++d) slope.col(8 + d) = -2 * xi[d] * Vec3::Unit(d);
        slope *= 2 / h;
        Eigen::Matrix<double, 6, 33> strain = Eigen::Matrix<double, 6, 33>::Zero();
        for (int a = 0; a < 11; ++a) {
            const Vec3 s = slope.col(a);
            strain.block<6, 3>(0, 3 * a) << s[0], 0, 0, 0, s[1], 0, 0, 0, s[2], s[1], s[0], 0, 0,
                s[2], s[1], s[2], 0, s[0];
        }
        Eigen::Matrix<double, 6, 6> c = Eigen::Matrix<double, 6, 6>::Zero();
        c.topLeftCorner<3, 3>().setConstant(lambda);
        c.diagonal() << lambda + 2 * mu, lambda + 2 * mu, lambda + 2 * mu, mu, mu, mu;
        k += strain.transpose() * c * strain * (h * h * h / 8);
    }
    BrickMatrix corners = k.topLeftCorner<24, 24>();
    if (element == BrickElement::incompatible) {
        corners -= k.topRightCorner<24, 9>() *
                   k.bottomRightCorner<9, 9>().ldlt().solve(k.bottomLeftCorner<9, 24>());
    }
    return corners;
}

}  // namespace

TEST(BrickElement, EqualsGaussIntegrationAndNumericalCondensation)
{
    for (const double poisson : {0.0, 0.3, 0.499}) {
        for (const BrickElement element : {BrickElement::trilinear, BrickElement::incompatible}) {
            const Lame material = lame(2e5, poisson);
            const BrickMatrix expected = by_quadrature(0.2, material, element);
            const BrickMatrix k = brick_stiffness(0.2, material, element);
            EXPECT_LT((k - expected).norm(), 1e-13 * expected.norm()) << poisson;  // some 100 eps
        }
    }
}

TEST(BrickElement, OnlyRigidMotionsCostNoForce)
{
    for (const BrickElement element : {BrickElement::trilinear, BrickElement::incompatible}) {
        const BrickMatrix k = brick_stiffness(0.5, lame(1, 0.3), element);
        const Eigen::SelfAdjointEigenSolver<BrickMatrix> eigen(k);
        EXPECT_LT(eigen.eigenvalues()[5], 1e-14);  // six rigid motions
        EXPECT_GT(eigen.eigenvalues()[6], 1e-2);   // and no hourglass
    }
}

TEST(BrickElement, PassesThePatchTest)
{
    // u = A x has the constant stress mu (A + A^T) + lambda tr A, whose forces on a corner are
    // stress * outward area of its three quarter faces: (h^2 / 4) stress s_a.
    const double h = 0.3;
    const Lame material = lame(10, 0.25);
    const geometry::Random random(1);
    Mat3 a;
    for (int i = 0; i < 9; ++i) a(i) = random.unit(std::uint64_t(i)) - 0.5;
    const Mat3 stress =
        material.mu * (a + a.transpose()) + material.lambda * a.trace() * Mat3::Identity();
    BrickVector u, expected;
    for (unsigned corner = 0; corner < 8; ++corner) {
        u.segment<3>(3 * corner) = a * (h / 2 * sign(corner));
        expected.segment<3>(3 * corner) = h * h / 4 * stress * sign(corner);
    }
    for (const BrickElement element : {BrickElement::trilinear, BrickElement::incompatible}) {
        EXPECT_LT((brick_forces(u, h, material, element) - expected).norm(), 1e-14);
    }
}

TEST(BrickElement, LameConstantsFollowFromYoungAndPoisson)
{
    // Steel-like: E = mu (3 lambda + 2 mu) / (lambda + mu), nu = lambda / (2 (lambda + mu)).
    const auto [lambda, mu] = lame(210e9, 0.3);
    EXPECT_NEAR(mu * (3 * lambda + 2 * mu) / (lambda + mu), 210e9, 1e-3);
    EXPECT_NEAR(lambda / (2 * (lambda + mu)), 0.3, 1e-15);
}

TEST(BrickElement, StiffnessFollowsTheFillOfACube)
{
    geometry::Cubes cubes;
    cubes.fill = {1, 0.4, 0, 1.7};
    EXPECT_EQ(stiffness_share(cubes, 0, Weighting::filled), 1);
    EXPECT_EQ(stiffness_share(cubes, 1, Weighting::filled), 0.4);
    EXPECT_EQ(stiffness_share(cubes, 2, Weighting::filled), 1e-3);
    EXPECT_EQ(stiffness_share(cubes, 3, Weighting::filled), 1);
    EXPECT_EQ(stiffness_share(cubes, 1, Weighting::full), 1);
}
