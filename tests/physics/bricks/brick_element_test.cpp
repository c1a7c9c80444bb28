#include "physics/bricks/brick_element.hpp"

#include "geometry/base/random.hpp"
#include "physics/body/stiffness.hpp"
#include "tests/physics/cube_fixtures.hpp"

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

// Energy of a bar of 2 n x n x n cubes, its ends clamped and one turned against the other: the
// torsional stiffness (J) of a bar of 2 x 1 x 1 m that cannot warp at its ends.
double torsion(int n, double poisson, BrickElement element)
{
    const auto cubes = fixtures::box(2 * n, n, n, 1.0 / n);
    const BrickMatrix k = brick_stiffness(cubes.size, lame(1, poisson), element);
    const auto size = Eigen::Index(3 * cubes.corner_count());
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, size);
    for (const auto& corners : cubes.corners) {
        for (Eigen::Index a = 0; a < 8; ++a) {
            for (Eigen::Index b = 0; b < 8; ++b) {
                all.block<3, 3>(3 * corners[std::size_t(a)], 3 * corners[std::size_t(b)]) +=
                    k.block<3, 3>(3 * a, 3 * b);
            }
        }
    }
    Eigen::VectorXd u = Eigen::VectorXd::Zero(size);
    std::vector<Eigen::Index> free;
    for (std::uint32_t c = 0; c < cubes.corner_count(); ++c) {
        const Vec3 p = cubes.corner_position(c);
        const bool turned = cubes.corner[c].x() == 2 * n;
        if (turned) u.segment<3>(3 * c) = Vec3(0, 0.5 - p.z(), p.y() - 0.5);
        if (turned || cubes.corner[c].x() == 0) continue;
        for (Eigen::Index i = 0; i < 3; ++i) free.push_back(3 * c + i);
    }
    const Eigen::VectorXd push = -(all * u);
    const Eigen::MatrixXd inner = all(free, free);
    const Eigen::VectorXd pushed = push(free), moved = inner.llt().solve(pushed);
    u(free) = moved;
    return u.dot(all * u);
}

}  // namespace

TEST(BrickElement, TheRelaxedOneDoesNotLockInTorsion)
{
    // Torsion is shear: its stiffness goes with 1 / (1 + nu), whatever the bulk modulus. What ends
    // that cannot warp add is a share of it that changes little from nu = 0.4 on.
    const double expected = 1.4 / 1.4999;
    const auto ratio = [](BrickElement element) {
        return torsion(4, 0.4999, element) / torsion(4, 0.4, element);
    };
    EXPECT_NEAR(ratio(BrickElement::relaxed), expected, 0.01 * expected);
    EXPECT_GT(ratio(BrickElement::incompatible), 1.05 * expected);
}

TEST(BrickElement, ABodyIsRelaxedWhereAnyOfItIsNearlyIncompressible)
{
    auto cubes = fixtures::box(2, 1, 1, 0.1, {.poisson = 0.45});
    EXPECT_EQ(element_of(cubes, BrickElement::incompatible), BrickElement::incompatible);
    cubes.poisson[1] = 0.46;
    EXPECT_EQ(element_of(cubes, BrickElement::incompatible), BrickElement::relaxed);
    EXPECT_EQ(element_of(cubes, BrickElement::trilinear), BrickElement::trilinear);
    EXPECT_EQ(element_of(cubes, BrickElement::one_point), BrickElement::one_point);
}

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
    for (const BrickElement element : {BrickElement::trilinear, BrickElement::incompatible,
                                       BrickElement::one_point, BrickElement::relaxed}) {
        const BrickMatrix k = brick_stiffness(0.5, lame(1, 0.3), element);
        const Eigen::SelfAdjointEigenSolver<BrickMatrix> eigen(k);
        EXPECT_LT(eigen.eigenvalues()[5], 1e-14);  // six rigid motions
        EXPECT_GT(eigen.eigenvalues()[6], 1e-2);   // and no hourglass
    }
}

TEST(BrickElement, TheOnePointOneBendsAndTwistsAsABarOfOneCube)
{
    // Bent with curvature k about one axis: E I k^2 h / 2, I = h^4 / 12. Twisted by t a metre:
    // mu J t^2 h / 2, J = h^4 / 6, the polar moment. Without a share of the volume at any ratio.
    const double h = 0.3, curvature = 0.7, twist = 0.4;
    for (const double poisson : {0.0, 0.3, 0.4999}) {
        const Lame material = lame(10, poisson);
        for (unsigned i = 0; i < 3; ++i) {
            const unsigned j = (i + 1) % 3, l = (i + 2) % 3;
            BrickVector bent = BrickVector::Zero(), turned = bent;
            for (unsigned a = 0; a < 8; ++a) {
                const Vec3 at = h / 2 * sign(a);
                bent(3 * a + i) = curvature * at[i] * at[j];
                turned(3 * a + j) = -twist * at[i] * at[l];
                turned(3 * a + l) = twist * at[i] * at[j];
            }
            const auto energy = [&](const BrickVector& u) {
                return 0.5 * u.dot(brick_forces(u, h, material, BrickElement::one_point));
            };
            EXPECT_NEAR(energy(bent), 10 * std::pow(h, 5) * curvature * curvature / 24, 1e-15);
            EXPECT_NEAR(energy(turned), material.mu * std::pow(h, 5) * twist * twist / 12, 1e-15);
        }
    }
}

TEST(BrickElement, APlateOfOnePointBricksIsTooSoftByWhatTheyLeaveOut)
{
    // Energies of a plate across z over those of Kirchhoff's, D = E h^3 / (12 (1 - nu^2)): bent one
    // way, both ways alike, against each other, and twisted.
    const double h = 0.2, nu = 0.3;
    const double d = 10 * std::pow(h, 3) / (12 * (1 - nu * nu));
    const auto ratio = [&](double kx, double ky, double kxy) {
        BrickVector u;
        for (unsigned a = 0; a < 8; ++a) {
            const Vec3 at = h / 2 * sign(a);
            u.segment<3>(3 * a) =
                Vec3(-at.z() * (kx * at.x() + kxy * at.y()), -at.z() * (ky * at.y() + kxy * at.x()),
                     kxy * at.x() * at.y());
        }
        const double plate =
            0.5 * d * h * h * (kx * kx + ky * ky + 2 * nu * kx * ky + 2 * (1 - nu) * kxy * kxy);
        return 0.5 * u.dot(brick_forces(u, h, lame(10, nu), BrickElement::one_point)) / plate;
    };
    EXPECT_NEAR(ratio(1, 0, 0), 1 - nu * nu, 1e-12);
    EXPECT_NEAR(ratio(1, 1, 0), 1 - nu, 1e-12);
    EXPECT_NEAR(ratio(1, -1, 0), 1 + nu, 1e-12);
    EXPECT_NEAR(ratio(0, 0, 1), 0.75, 1e-12);
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
    for (const BrickElement element : {BrickElement::trilinear, BrickElement::incompatible,
                                       BrickElement::one_point, BrickElement::relaxed}) {
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
