// Cubes with a finite element of their own among the bricks.

#include "physics/bricks/own_bricks.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/random.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/brick_kernels.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/every_target.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

namespace {

using namespace physics;
using Eigen::Index;
using geometry::Cubes;
using geometry::OwnElement;
using geometry::Random;
using geometry::Vec3;

std::array<float, 36> mass_triangle(const CubeMass& mass)
{
    std::array<float, 36> out{};
    std::size_t at = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b <= a; ++b) out[at++] = static_cast<float>(mass[a][b]);
    }
    return out;
}

// That of a box which is stiff along x by `more` and has its mass near corner 0.
OwnElement lopsided(double more)
{
    BrickMatrix stretch = BrickMatrix::Zero();
    for (Index a = 0; a < 8; ++a) {
        for (Index b = 0; b < 8; ++b) {
            stretch(3 * a, 3 * b) = (a % 2 == b % 2 ? 1 : -1) / 16.0;
        }
    }
    // Of points at 0.2 and 0.4 of the edge, with half of the mass each.
    CubeMass mass{};
    for (const double at : {0.2, 0.4}) {
        std::array<double, 8> w;
        for (unsigned a = 0; a < 8; ++a) {
            w[a] = 1;
            for (unsigned i = 0; i < 3; ++i) w[a] *= (a >> i & 1) != 0 ? at : 1 - at;
        }
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) mass[a][b] += w[a] * w[b] / 2;
        }
    }
    return {lower_triangle(brick_stiffness(1, lame(1, 0.3)) + more * stretch), mass_triangle(mass)};
}

// Every third cube, of which each differs.
Cubes with_own(Cubes cubes)
{
    cubes.own.assign(cubes.count(), geometry::no_index);
    for (std::size_t c = 0; c < cubes.count(); c += 3) {
        cubes.own[c] = static_cast<std::uint32_t>(cubes.elements.size());
        cubes.elements.push_back(lopsided(0.1 + 0.01 * double(c)));
        cubes.fill[c] = 0.4;  // which does not count for these
    }
    return cubes;
}

// The elements that cubes have anyway, as their own.
Cubes with_usual(Cubes cubes)
{
    cubes.own.resize(cubes.count());
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        cubes.own[c] = static_cast<std::uint32_t>(c);
        const BrickMatrix k = brick_stiffness(1, lame(1, cubes.poisson[c]));
        cubes.elements.push_back({lower_triangle(k), mass_triangle(cube_mass_matrix())});
    }
    return cubes;
}

// K and M of a body, dense, over corners in their order.
struct KnownSum {
    Eigen::MatrixXd stiffness, mass;

    explicit KnownSum(const Cubes& cubes)
    {
        const auto n = Index(cubes.corner_count());
        stiffness = Eigen::MatrixXd::Zero(3 * n, 3 * n);
        mass = Eigen::MatrixXd::Zero(n, n);
        const CubeMass usual = cube_mass_matrix();
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const BrickMatrix k =
                cubes.is_own(c) ? BrickMatrix(stiffness_of(cubes.elements[cubes.own[c]]) *
                                              cubes.young[c] * cubes.size)
                                : BrickMatrix(cubes.fill[c] *
                                              brick_stiffness(cubes.size, lame(cubes.young[c],
                                                                               cubes.poisson[c])));
            const CubeMass m = mass_of_cube(cubes, c, usual);
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) {
                    const Index i = cubes.corners[c][a], j = cubes.corners[c][b];
                    stiffness.block<3, 3>(3 * i, 3 * j) +=
                        k.block<3, 3>(Index(3 * a), Index(3 * b));
                    mass(i, j) += cubes.mass[c] * m[a][b];
                }
            }
        }
    }
};

TEST(OwnBricks, ForcesAndMomentaAreThoseOfTheirMatrices)
{
    const Cubes cubes = with_own(fixtures::blob(5, 60, 0.1));
    const KnownSum dense(cubes);
    const Random random(4);
    std::vector<Vec3> v(cubes.corner_count());
    Eigen::VectorXd u(3 * Index(v.size()));
    for (Index i = 0; i < u.size(); ++i) u[i] = random.unit(std::uint64_t(i)) - 0.5;
    const Eigen::VectorXd expected = dense.stiffness * u;
    on_every_target([&](const char* target) {
        const BricksBody body = make_bricks(cubes);
        BrickElasticity elasticity(body);
        const auto x = by_slot(body.base, corner_positions(cubes));
        Aligned<double> force(elasticity.room()), p(body.base.numbers, 0), q(elasticity.room());
        elasticity.forces(x.data(), force.data());
        elasticity.weigh(2, 0);
        for (std::size_t k = 0; k < v.size(); ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                p[4 * body.base.slot_of(k) + i] = u[Index(3 * k + i)];
            }
        }
        elasticity.multiply(p.data(), q.data());
        Aligned<double> n(elasticity.room(), 0);
        EXPECT_TRUE(elasticity.excess(Lumped::mass, p.data(), n.data()));
        for (std::size_t k = 0; k < v.size(); ++k) {
            const std::size_t at = body.base.slot_of(k);
            for (std::size_t i = 0; i < 3; ++i) {
                EXPECT_NEAR(q[4 * at + i], 2 * expected[Index(3 * k + i)],
                            1e-7 * expected.lpNorm<Eigen::Infinity>())  // single precision
                    << target;
                double momentum = 0;
                for (std::size_t j = 0; j < v.size(); ++j) {
                    momentum += dense.mass(Index(k), Index(j)) * u[Index(3 * j + i)];
                }
                EXPECT_NEAR(body.base.mass[at] * p[4 * at + i] - n[4 * at + i], momentum,
                            1e-7 * dense.mass.cwiseAbs().maxCoeff())
                    << target;
            }
        }
    });
}

TEST(OwnBricks, ForcesAreTheSlopeOfTheEnergyInABentBody)
{
    const Cubes cubes = with_own(fixtures::box(4, 2, 2, 0.1));
    const BricksBody body = make_bricks(cubes);
    BrickElasticity elasticity(body);
    const Random random(9);
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        const double angle = 4 * x[k].x();  // and turned by up to 1.6
        x[k] = Vec3(x[k].x(), std::cos(angle) * x[k].y() - std::sin(angle) * x[k].z(),
                    std::sin(angle) * x[k].y() + std::cos(angle) * x[k].z());
        for (int i = 0; i < 3; ++i) x[k][i] += 0.02 * (random.unit(3 * k + std::size_t(i)) - 0.5);
    }
    const auto at = by_slot(body.base, x);
    Aligned<double> force(elasticity.room(), 0);
    elasticity.forces(at.data(), force.data());
    double largest = 0;
    for (const double f : force) largest = std::max(largest, std::abs(f));
    for (std::size_t k = 0; k < x.size(); k += 5) {
        for (std::size_t i = 0; i < 3; ++i) {
            constexpr double step = 1e-6;
            auto low = at, high = at;
            low[4 * k + i] -= step, high[4 * k + i] += step;
            const double slope =
                (elasticity.energy(high.data()) - elasticity.energy(low.data())) / (2 * step);
            EXPECT_NEAR(force[4 * k + i], -slope, 1e-6 * largest);
        }
    }
}

TEST(OwnBricks, MoveAsTheUsualOnesWhereTheirElementIsTheUsual)
{
    // In single precision: a factor of the whole body, and multigrid, precondition the steps.
    for (const Cubes& cubes : {fixtures::box(12, 3, 2, 0.1), fixtures::box(13, 13, 13, 0.1)}) {
        Loads loads;
        loads.forces.push_back({});  // gravity
        State usual = rest_state(make_bricks(cubes)), own = usual;
        loads.pins.corner = fixtures::first_layer(cubes);
        for (const auto k : loads.pins.corner) {
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        const BricksBody a = make_bricks(cubes), b = make_bricks(with_usual(cubes));
        int iterations[2] = {0, 0};
        for (int frame = 0; frame < 2; ++frame) {
            usual = advance(a, usual, loads, 1.0 / 24, {});
            own = advance(b, own, loads, 1.0 / 24, {});
            iterations[0] += usual.report.iterations, iterations[1] += own.report.iterations;
        }
        double sag = 0;
        for (std::size_t k = 0; k < usual.x.size(); ++k) {
            sag = std::max(sag, (usual.x[k] - cubes.corner_position(k)).norm());
        }
        EXPECT_GT(sag, 1e-3);
        for (std::size_t k = 0; k < usual.x.size(); ++k) {
            EXPECT_LT((usual.x[k] - own.x[k]).norm(), 2e-5 * sag);
        }
        EXPECT_LE(iterations[1], iterations[0] * 3 / 2 + 2);
    }
}

TEST(OwnBricks, StayWithTheirCubesWhereSomeAreKept)
{
    const Cubes cubes = with_own(fixtures::box(4, 3, 2, 0.1));
    std::vector<std::uint8_t> keep(cubes.count(), 1);
    keep[0] = keep[4] = keep[6] = 0;
    const Cubes some = kept(cubes, keep);
    std::size_t at = 0, own = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (keep[c] == 0) continue;
        EXPECT_EQ(some.is_own(at), cubes.is_own(c));
        if (cubes.is_own(c)) {
            ++own;
            EXPECT_EQ(some.elements[some.own[at]].stiffness,
                      cubes.elements[cubes.own[c]].stiffness);
        }
        ++at;
    }
    EXPECT_EQ(some.elements.size(), own);
}

}  // namespace
