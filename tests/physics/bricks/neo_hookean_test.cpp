// Bricks of rubber: the material alone, and bodies of it.

#include "physics/bricks/neo_hookean.hpp"

#include "geometry/base/random.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/state/choose_corners.hpp"
#include "physics/state/measure.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace physics;
using fixtures::box;
using geometry::Cubes;
using geometry::Mat3;
using geometry::Random;
using geometry::Vec3;

constexpr BrickElement hookean_elements[] = {BrickElement::incompatible, BrickElement::trilinear,
                                             BrickElement::one_point, BrickElement::relaxed};

// As it is, squashed, flat, a line, a point and inside out.
std::vector<Mat3> gradients()
{
    const Random random(3);
    std::vector<Mat3> out;
    for (std::size_t n = 0; n < 20; ++n) {
        Mat3 f;
        for (std::size_t i = 0; i < 9; ++i) f.data()[i] = 3 * (random.unit(9 * n + i) - 0.5);
        out.push_back(f);
    }
    out.push_back(Mat3::Identity());
    out.push_back(Vec3(1, 1, -1).asDiagonal());
    out.push_back(Vec3(1, 2, 0).asDiagonal());
    out.push_back(Vec3(1, 0, 0).asDiagonal());
    out.push_back(Mat3::Zero());
    return out;
}

TEST(NeoHookean, StressIsTheSlopeOfTheEnergyAndTheHessianThatOfTheStress)
{
    const double step = 1e-5;
    for (const double poisson : {-0.4, 0.0, 0.3, 0.49}) {
        const NeoHookean law(lame(1, poisson));
        for (const Mat3& f : gradients()) {
            const Mat3 stress = law.stress(f);
            const Mat9 hessian = law.hessian(f, false);
            for (Eigen::Index i = 0; i < 9; ++i) {
                Mat3 more = f, less = f;
                more.data()[i] += step, less.data()[i] -= step;
                EXPECT_NEAR(stress.data()[i], (law.energy(more) - law.energy(less)) / (2 * step),
                            1e-6 * (1 + stress.norm()));
                const Mat3 slope = (law.stress(more) - law.stress(less)) / (2 * step);
                for (Eigen::Index k = 0; k < 9; ++k) {
                    EXPECT_NEAR(hessian(k, i), slope.data()[k], 1e-6 * (1 + hessian.norm()));
                }
            }
        }
    }
}

TEST(NeoHookean, IsTheLinearMaterialAtSmallStrainsAndAtRestHasNoForce)
{
    const Lame material = lame(2, 0.4);
    const NeoHookean law(material);
    EXPECT_LT(law.stress(Mat3::Identity()).norm(), 1e-15 * material.lambda);
    EXPECT_EQ(law.energy(Mat3::Identity()), 0);
    const Mat9 hessian = law.hessian(Mat3::Identity(), false);
    Mat3 df;
    df << 1, 2, 3, 4, 5, 6, 7, 8, 10;
    const Eigen::Matrix<double, 9, 1> dp =
        hessian * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(df.data());
    const Mat3 linear =
        material.mu * (df + df.transpose()) + material.lambda * df.trace() * Mat3::Identity();
    EXPECT_LT((Eigen::Map<const Mat3>(dp.data()) - linear).norm(), 1e-13 * linear.norm());
}

TEST(NeoHookean, ThePositiveHessianLeavesOutTheNegativeDirectionsAndNothingElse)
{
    for (const double poisson : {0.0, 0.45}) {
        const NeoHookean law(lame(1, poisson));
        for (const Mat3& f : gradients()) {
            const Mat9 whole = law.hessian(f, false);
            const Eigen::SelfAdjointEigenSolver<Mat9> eigen(whole);
            const Mat9 expected = eigen.eigenvectors() *
                                  eigen.eigenvalues().cwiseMax(0).asDiagonal() *
                                  eigen.eigenvectors().transpose();
            EXPECT_LT((law.hessian(f, true) - expected).norm(), 1e-12 * (1 + whole.norm()));
        }
    }
}

// A twisted, stretched blob of rubber.
struct Rubber {
    Cubes cubes = fixtures::blob(21, 20, 0.1, {.poisson = 0.3});
    BricksBody body;
    BrickElasticity elasticity;
    std::vector<Vec3> x;

    explicit Rubber(BrickElement element)
        : body(make_bricks(cubes, {.element = element, .law = BrickLaw::neo_hookean})),
          elasticity(body)
    {
        const Random random(4);
        const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, -1).normalized());
        for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
            Vec3 moved;
            for (std::size_t i = 0; i < 3; ++i) {
                moved[Eigen::Index(i)] = random.unit(5000 + 3 * k + i) - 0.5;
            }
            const Vec3 stretched = Vec3(1.6, 0.8, 1).cwiseProduct(cubes.corner_position(k));
            x.push_back(turn * (stretched + 0.3 * cubes.size * moved));
        }
    }
    double energy(const std::vector<Vec3>& at)
    {
        return elasticity.energy(by_slot(body.base, at).data());
    }
    std::vector<Vec3> forces(const std::vector<Vec3>& at)
    {
        Aligned<double> f(elasticity.room(), 0);
        elasticity.forces(by_slot(body.base, at).data(), f.data());
        return by_corner(f);
    }
    // K p as products and, summed, as the cubes' matrices have it.
    std::vector<Vec3> times(const std::vector<Vec3>& p)
    {
        elasticity.weigh(1, 0);
        Aligned<double> y(elasticity.room(), 0);
        elasticity.multiply(by_slot(body.base, p).data(), y.data());
        return by_corner(y);
    }
    std::vector<Vec3> times_by_cube(const std::vector<Vec3>& p)
    {
        elasticity.weigh(1, 0);
        std::vector<BrickMatrix> matrices;
        EXPECT_TRUE(elasticity.cube_matrices(matrices));
        std::vector<Vec3> out(p.size(), Vec3::Zero());
        for (std::size_t c = 0; c < matrices.size(); ++c) {
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) {
                    out[cubes.corners[c][a]] +=
                        matrices[c].block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b)) *
                        p[cubes.corners[c][b]];
                }
            }
        }
        return out;
    }
    std::vector<Vec3> by_corner(const Aligned<double>& by_slot) const
    {
        std::vector<Vec3> out;
        for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
            out.push_back(Eigen::Map<const Vec3>(&by_slot[4 * body.base.slot_of(k)]));
        }
        return out;
    }
};

double largest(const std::vector<Vec3>& v)
{
    double most = 0;
    for (const Vec3& each : v) most = std::max(most, each.norm());
    return most;
}

std::vector<Vec3> some_directions(std::size_t count)
{
    const Random random(8);
    std::vector<Vec3> p(count);
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t i = 0; i < 3; ++i) p[k][Eigen::Index(i)] = random.unit(3 * k + i) - 0.5;
    }
    return p;
}

TEST(NeoHookean, ForcesOfABodyAreTheSlopeOfItsEnergyAndHaveNoNetTorque)
{
    for (const BrickElement element : hookean_elements) {
        Rubber rubber(element);
        const std::vector<Vec3> force = rubber.forces(rubber.x);
        const double step = 1e-6 * rubber.cubes.size;
        for (const std::size_t k : {std::size_t{0}, std::size_t{7}, rubber.x.size() - 1}) {
            for (Eigen::Index i = 0; i < 3; ++i) {
                std::vector<Vec3> more = rubber.x, less = rubber.x;
                more[k][i] += step, less[k][i] -= step;
                const double slope = (rubber.energy(more) - rubber.energy(less)) / (2 * step);
                EXPECT_NEAR(force[k][i], -slope, 1e-6 * largest(force));
            }
        }
        Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
        for (std::size_t k = 0; k < force.size(); ++k) {
            sum += force[k];
            torque += rubber.x[k].cross(force[k]);
        }
        EXPECT_LT(sum.norm(), 1e-10 * largest(force));
        EXPECT_LT(torque.norm(), 1e-10 * largest(force));
    }
}

TEST(NeoHookean, TheHessianOfABodyIsTheDerivativeOfItsForce)
{
    for (const BrickElement element : hookean_elements) {
        Rubber rubber(element);
        const auto p = some_directions(rubber.x.size());
        std::vector<Vec3> more = rubber.x, less = rubber.x;
        const double step = 1e-6 * rubber.cubes.size;
        for (std::size_t k = 0; k < p.size(); ++k) more[k] += step * p[k], less[k] -= step * p[k];
        const std::vector<Vec3> high = rubber.forces(more), low = rubber.forces(less);
        ASSERT_TRUE(rubber.elasticity.use_hessian(true));
        rubber.forces(rubber.x);
        const std::vector<Vec3> product = rubber.times(p), by_cube = rubber.times_by_cube(p);
        const double scale = largest(product);
        for (std::size_t k = 0; k < p.size(); ++k) {
            EXPECT_LT((product[k] - (low[k] - high[k]) / (2 * step)).norm(), 1e-6 * scale);
            EXPECT_LT((product[k] - by_cube[k]).norm(), 1e-12 * scale);
        }
    }
}

TEST(NeoHookean, WhatStepsSolveWithIsNeverNegativeAndItsDiagonalBoundsIt)
{
    for (const BrickElement element : hookean_elements) {
        Rubber rubber(element);
        // Some cubes flat, some inside out.
        for (std::size_t k = 0; k < rubber.x.size(); k += 3) rubber.x[k] = Vec3::Zero();
        rubber.elasticity.use_hessian(true);
        rubber.forces(rubber.x);
        rubber.elasticity.use_hessian(false);
        rubber.elasticity.weigh(1, 0);
        std::vector<BrickMatrix> matrices;
        ASSERT_TRUE(rubber.elasticity.cube_matrices(matrices));
        for (const BrickMatrix& m : matrices) {
            const Eigen::SelfAdjointEigenSolver<BrickMatrix> eigen(m, Eigen::EigenvaluesOnly);
            EXPECT_GT(eigen.eigenvalues()[0], -1e-12 * eigen.eigenvalues()[23]);
        }
        Aligned<double> d(rubber.elasticity.room(), 0);
        rubber.elasticity.add_diagonal(d.data());
        auto v = some_directions(rubber.x.size());
        double most = 0;
        for (int i = 0; i < 100; ++i) {
            v = rubber.times(v);
            for (std::size_t k = 0; k < v.size(); ++k) v[k] /= d[4 * rubber.body.base.slot_of(k)];
            most = largest(v);
            for (Vec3& each : v) each /= most;
        }
        EXPECT_LE(most, 1.001 * rubber.body.largest_eigenvalue);
    }
}

// Of a strip pulled to `stretch` times its length, its other stretch and the force by its area at
// rest: the root of the stress across it.
struct Pulled {
    double across, stress;
};
Pulled pulled(const NeoHookean& law, double stretch)
{
    double low = 0.01, high = 2;
    for (int i = 0; i < 200; ++i) {
        const double t = 0.5 * (low + high);
        const Mat3 f = Vec3(stretch, t, t).asDiagonal();
        (law.stress(f)(1, 1) > 0 ? high : low) = t;
    }
    const Mat3 f = Vec3(stretch, low, low).asDiagonal();
    return {low, law.stress(f)(0, 0)};
}

// RubberBar of 6 x 2 x 2 cubes of 0.1 m between planes along x that it may slide on, one of which
// is moved; it may slide on y = 0 and z = 0 too.
struct RubberBar {
    Cubes cubes;
    BricksBody body;
    Loads loads;

    RubberBar(double poisson, double stretch, BrickLaw law = BrickLaw::neo_hookean)
        : cubes(box(6, 2, 2, 0.1, {.young = 1e5, .poisson = poisson})),
          body(make_bricks(cubes, {.law = law}))
    {
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            const auto at = cubes.corner[k] - cubes.corner[0];
            const bool x = at.x() == 0 || at.x() == 6;
            const int axes = int(x) + 2 * int(at.y() == 0) + 4 * int(at.z() == 0);
            if (axes == 0) continue;
            Vec3 target = cubes.corner_position(k) - cubes.corner_position(0);
            if (at.x() == 6) target.x() *= stretch;
            loads.pins.corner.push_back(k);
            loads.pins.axes.push_back(static_cast<std::uint8_t>(axes));
            loads.pins.target.push_back(target + cubes.corner_position(0));
        }
    }
    State settled() const { return settle(body, rest_state(body), loads, {.tolerance = 1e-9}); }
    // The stretch along y.
    double across(const State& state) const
    {
        double most = 0;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            most = std::max(most, state.x[k].y() - cubes.corner_position(0).y());
        }
        return most / 0.2;
    }
};

TEST(NeoHookean, AStripStretchedFarHasTheClosedFormsWidthAndStress)
{
    for (const double poisson : {0.3, 0.49}) {
        for (const double stretch : {0.8, 1.5, 3.0}) {
            const RubberBar bar(poisson, stretch);
            const State state = bar.settled();
            EXPECT_TRUE(state.report.converged);
            const NeoHookean law(lame(1e5, poisson));
            const Pulled expected = pulled(law, stretch);
            EXPECT_NEAR(bar.across(state), expected.across, 1e-6);
            // Per area of now.
            const double stress = std::abs(expected.stress) / (expected.across * expected.across);
            const Strained strained = strain(bar.body, state);
            for (const float each : strained.stress) EXPECT_NEAR(each, stress, 1e-4 * stress);
            EXPECT_NEAR(strained.energy,
                        law.energy(Vec3(stretch, expected.across, expected.across).asDiagonal()) *
                            0.024,
                        1e-6 * strained.energy);
        }
    }
}

TEST(NeoHookean, KeepsItsVolumeWhereTheLinearLawLosesIt)
{
    const double stretch = 2;
    const auto volume = [&](BrickLaw law) {
        const RubberBar bar(0.49, stretch, law);
        const double across = bar.across(bar.settled());
        return stretch * across * across;
    };
    EXPECT_NEAR(volume(BrickLaw::neo_hookean), 1, 0.03);
    // tr(S - I) is about 0: across is 1/2.
    EXPECT_NEAR(volume(BrickLaw::corotated), 0.5, 0.05);
}

TEST(NeoHookean, ALargeBodyWithCoarseGridsComesToTheSameShape)
{
    // 2,000 cubes are the fewest that get coarse grids.
    const Cubes cubes = box(20, 10, 10, 0.1, {.young = 1e5, .poisson = 0.45});
    BricksBody body = make_bricks(cubes, {.law = BrickLaw::neo_hookean});
    Loads loads;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const auto at = cubes.corner[k].x() - cubes.corner[0].x();
        if (at != 0 && at != 20) continue;
        Vec3 target = cubes.corner_position(k);
        if (at == 20) target.x() += 0.3;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(target);
    }
    const auto stepped = [&] {
        const State state = advance(body, rest_state(body), loads, 0.05,
                                    {.newton_iterations = 30, .tolerance = 1e-7});
        EXPECT_TRUE(state.report.converged);
        return state.x;
    };
    const std::vector<Vec3> x = stepped();
    body.multigrids = nullptr;
    body.dissections = nullptr;
    body.factors = std::make_shared<FactorCache>();
    const std::vector<Vec3> plain = stepped();
    for (std::size_t k = 0; k < x.size(); ++k) EXPECT_LT((x[k] - plain[k]).norm(), 1e-5);
}

TEST(NeoHookean, ABodyComesBackFromInsideOutFlatAndAPoint)
{
    const Cubes cubes = box(4, 4, 4, 0.1, {.young = 1e5, .poisson = 0.45, .mass_damping = 2});
    const BricksBody body = make_bricks(cubes, {.law = BrickLaw::neo_hookean});
    const Vec3 middle = 0.5 * (cubes.corner_position(0) +
                               cubes.corner_position(std::uint32_t(cubes.corner_count() - 1)));
    for (const Vec3& scale : {Vec3(1, 1, -1), Vec3(1, 0, 1), Vec3(0, 0, 0), Vec3(4, 4, 4)}) {
        State state = rest_state(body);
        const Random random(2);
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            Vec3 noise;
            for (std::size_t i = 0; i < 3; ++i) {
                noise[Eigen::Index(i)] = 1e-3 * (random.unit(3 * k + i) - 0.5);
            }
            state.x[k] = middle + scale.cwiseProduct(state.x[k] - middle) + noise;
        }
        for (int i = 0; i < 120; ++i) {
            state = advance(body, state, {}, 1.0 / 24, {.newton_iterations = 20});
        }
        double most = 0;  // distances between corners, beside those at rest
        for (std::uint32_t k = 1; k < state.x.size(); ++k) {
            const double length = (cubes.corner_position(k) - cubes.corner_position(0)).norm();
            most = std::max(most, std::abs((state.x[k] - state.x[0]).norm() - length));
        }
        EXPECT_LT(most, 1e-3) << scale.transpose();
    }
}

TEST(NeoHookean, WhatItCannotDoIsToldWithTheRemedy)
{
    const Cubes cubes = box(1, 1, 1, 0.1);
    try {
        make_bricks(cubes, {.law = BrickLaw::neo_hookean, .plastic = {.yield = 0.1}});
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("Set plastic.yield to 0"), std::string::npos);
    }
}

}  // namespace
