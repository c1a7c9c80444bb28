// Bricks whose rest shape gives way for good.

#include "physics/bricks/brick_flow.hpp"

#include "geometry/base/random.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/brick_kernels.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/choose_corners.hpp"
#include "physics/state/measure.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace physics;
using fixtures::box;
using geometry::Cubes;
using geometry::Random;
using geometry::Vec3;

constexpr BrickElement flowing_elements[] = {BrickElement::incompatible, BrickElement::trilinear,
                                             BrickElement::one_point, BrickElement::relaxed};

// A twisted, stretched blob whose rest shapes have flowed as chance has it.
struct Flowed {
    Cubes cubes = fixtures::blob(21, 20, 0.1, {.poisson = 0.3});
    BricksBody body;
    BrickElasticity elasticity;
    std::vector<Vec3> x;

    explicit Flowed(BrickElement element)
        : body(make_bricks(cubes, {.element = element})), elasticity(body)
    {
        const Random random(4);
        std::vector<float> plastic(plastic_rows * cubes.count());
        for (std::size_t i = 0; i < plastic.size(); ++i) {
            plastic[i] = static_cast<float>(0.4 * (random.unit(i) - 0.5));
        }
        elasticity.load_plastic(plastic);
        const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, -1).normalized());
        for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
            Vec3 moved;
            for (std::size_t i = 0; i < 3; ++i) {
                moved[Eigen::Index(i)] = random.unit(5000 + 3 * k + i) - 0.5;
            }
            x.push_back(turn * (cubes.corner_position(k) + 0.3 * cubes.size * moved));
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
        std::vector<Vec3> out;
        for (std::size_t k = 0; k < at.size(); ++k) {
            out.push_back(Eigen::Map<const Vec3>(&f[4 * body.base.slot_of(k)]));
        }
        return out;
    }
};

double longest_of(const std::vector<Vec3>& v)
{
    double most = 0;
    for (const Vec3& each : v) most = std::max(most, each.norm());
    return most;
}

TEST(BrickFlow, ForcesAreTheSlopeOfTheEnergy)
{
    for (const BrickElement element : flowing_elements) {
        Flowed flowed(element);
        const std::vector<Vec3> force = flowed.forces(flowed.x);
        const double step = 1e-6 * flowed.cubes.size;
        for (const std::size_t k : {std::size_t{0}, std::size_t{7}, flowed.x.size() - 1}) {
            for (Eigen::Index i = 0; i < 3; ++i) {
                std::vector<Vec3> more = flowed.x, less = flowed.x;
                more[k][i] += step, less[k][i] -= step;
                const double slope = (flowed.energy(more) - flowed.energy(less)) / (2 * step);
                EXPECT_NEAR(force[k][i], -slope, 1e-6 * longest_of(force));
            }
        }
    }
}

TEST(BrickFlow, ForcesOfAFlowedBodyHaveNoNetForceAndNoNetTorque)
{
    Flowed flowed(BrickElement::incompatible);
    const std::vector<Vec3> force = flowed.forces(flowed.x);
    Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t k = 0; k < force.size(); ++k) {
        sum += force[k];
        torque += flowed.x[k].cross(force[k]);
    }
    EXPECT_LT(sum.norm(), 1e-10 * longest_of(force));
    EXPECT_LT(torque.norm(), 1e-10 * longest_of(force));
}

TEST(BrickFlow, TheHessianIsTheDerivativeOfTheForce)
{
    for (const BrickElement element : flowing_elements) {
        Flowed flowed(element);
        const Random random(8);
        std::vector<Vec3> p = flowed.x, more = flowed.x, less = flowed.x;
        const double step = 1e-6 * flowed.cubes.size;
        for (std::size_t k = 0; k < p.size(); ++k) {
            for (std::size_t i = 0; i < 3; ++i)
                p[k][Eigen::Index(i)] = random.unit(3 * k + i) - 0.5;
            more[k] += step * p[k], less[k] -= step * p[k];
        }
        const std::vector<Vec3> high = flowed.forces(more), low = flowed.forces(less);
        ASSERT_TRUE(flowed.elasticity.use_hessian(true));
        flowed.forces(flowed.x);
        flowed.elasticity.weigh(1, 0);
        Aligned<double> y(flowed.elasticity.room(), 0);
        flowed.elasticity.multiply(by_slot(flowed.body.base, p).data(), y.data());
        std::vector<BrickMatrix> matrices;
        ASSERT_TRUE(flowed.elasticity.cube_matrices(matrices));
        std::vector<Vec3> product(p.size(), Vec3::Zero());
        for (std::size_t c = 0; c < matrices.size(); ++c) {
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) {
                    product[flowed.cubes.corners[c][a]] +=
                        matrices[c].block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b)) *
                        p[flowed.cubes.corners[c][b]];
                }
            }
        }
        const double scale = longest_of(product);
        for (std::size_t k = 0; k < p.size(); ++k) {
            const Vec3 expected = (low[k] - high[k]) / (2 * step);
            const Vec3 found = Eigen::Map<const Vec3>(&y[4 * flowed.body.base.slot_of(k)]);
            EXPECT_LT((found - expected).norm(), 1e-6 * scale);
            EXPECT_LT((product[k] - expected).norm(), 1e-6 * scale);
        }
    }
}

TEST(BrickFlow, TheRestShapeStopsAtTheYieldStrainAndKeepsItsVolume)
{
    const PlasticOptions options{.yield = 0.05, .flow = 1e6, .limit = 0.9};
    BrickStrain now, rest;
    now.mean.diagonal() << 0.3, -0.1, -0.1;
    now.mean(0, 1) = now.mean(1, 0) = 0.1;
    now.bent(0, 0) = 0.2;
    now.bent(1, 3) = -0.1;
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 200; ++i) {
        const BrickStrain next = flowed(rest, now, options, 0.01);
        const geometry::Mat3 shape = geometry::Mat3::Identity() + next.mean;
        EXPECT_NEAR(shape.determinant(), 1, 1e-12);
        EXPECT_LT(size_of({next.mean - rest.mean, next.bent - rest.bent}), 0.25);
        rest = next;
        geometry::Mat3 beyond = now.mean - rest.mean;
        beyond.diagonal().array() -= beyond.trace() / 3;
        const double left = size_of({beyond, now.bent - rest.bent});
        EXPECT_LE(left, before * (1 + 1e-12));
        before = left;
    }
    EXPECT_LE(before, options.yield * (1 + 1e-6));
    EXPECT_GT(before, 0.9 * options.yield);
    // Below the yield strain, nothing flows.
    const BrickStrain same = flowed(rest, now, {.yield = 0.06, .flow = 1e6}, 0.01);
    EXPECT_EQ(same.mean, rest.mean);
    EXPECT_EQ(same.bent, rest.bent);
}

TEST(BrickFlow, TheRestShapeGoesNoFurtherThanTheLimit)
{
    BrickStrain now, rest;
    now.mean.diagonal() << 2, -0.4, -0.4;
    for (int i = 0; i < 50; ++i) rest = flowed(rest, now, {.yield = 0.01, .flow = 1e6}, 0.01);
    EXPECT_NEAR(size_of(rest), 0.5, 0.03);
    EXPECT_NEAR((geometry::Mat3::Identity() + rest.mean).determinant(), 1, 1e-12);
}

TEST(BrickFlow, NothingFlowsUnderPressureFromAllSides)
{
    BrickStrain now, rest;
    now.mean.diagonal() << -0.1, -0.1, -0.1;
    const PlasticOptions options{.yield = 0.05, .flow = 1e6};
    EXPECT_EQ(flowed(rest, now, options, 0.01).mean, rest.mean);
    // Nor is what is below the yield strain in shear lost by it.
    now.mean(0, 1) = now.mean(1, 0) = 0.02;
    EXPECT_EQ(flowed(rest, now, options, 0.01).mean, rest.mean);
    // Nor where it has flowed before.
    rest.mean.diagonal() << 0.2, 1 / std::sqrt(1.2) - 1, 1 / std::sqrt(1.2) - 1;
    now.mean = rest.mean - 0.1 * geometry::Mat3::Identity();
    EXPECT_EQ(flowed(rest, now, {.yield = 1e-6, .flow = 1e6}, 0.01).mean, rest.mean);
}

// A bar along x, held at its low end; its high end is taken along `way` (m) in a second, kept there
// for another and let go for three.
struct Pulled {
    State held, after;
};
Pulled pull(const Cubes& cubes, const PlasticOptions& plastic, const Vec3& way)
{
    const BricksBody body = make_bricks(cubes, {.plastic = plastic});
    const auto low = corners_at_end(cubes, 0, End::low, 0);
    const auto ends = corners_at_end(cubes, 0, End::both, 0);
    const std::vector<Vec3> rest = corner_positions(cubes);
    Pulled out;
    State state = rest_state(body);
    for (int frame = 1; frame <= 120; ++frame) {
        Loads loads;
        loads.pins = pins_at(cubes, frame <= 48 ? ends : low, Transform::Identity());
        const double share = std::min(1.0, frame / 24.0);
        for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
            const Vec3& from = rest[loads.pins.corner[p]];
            if (from.x() > rest[low.front()].x() + cubes.size / 2) {
                loads.pins.target[p] = from + share * way;
            }
        }
        state = advance(body, std::move(state), loads, 1.0 / 24, {.tolerance = 1e-6});
        if (frame == 48) out.held = state;
    }
    out.after = std::move(state);
    return out;
}

constexpr fixtures::Stuff damped{
    .young = 1e8, .poisson = 0.3, .mass_damping = 5, .stiffness_damping = 0.001};

TEST(BrickFlow, AStretchedBarKeepsWhatIsBeyondTheYieldStrain)
{
    const Cubes cubes = box(12, 2, 2, 0.1, damped);
    const auto length = [&](const State& state) {
        // Of the middle: ends are held in shape.
        double lo = 0, hi = 0;
        const std::vector<Vec3> rest = corner_positions(cubes);
        for (std::size_t k = 0; k < rest.size(); ++k) {
            if (std::abs(rest[k].x() - 0.4) < 1e-9) lo += state.x[k].x() / 9;
            if (std::abs(rest[k].x() - 0.8) < 1e-9) hi += state.x[k].x() / 9;
        }
        return hi - lo;
    };
    const double yield = 0.02, nu = 0.3;
    const Vec3 way(0.12, 0, 0);
    const Pulled kept = pull(cubes, {.yield = yield, .flow = 1e6}, way);
    // What springs back is the elastic part, e along the bar and -nu e across, of which 2/3 (1 +
    // nu) e and half of that are no change of volume.
    const double elastic = yield / ((1 + nu) * std::sqrt(2.0 / 3));
    const double expected = length(kept.held) - 0.4 * elastic;
    EXPECT_NEAR(length(kept.after) - 0.4, expected - 0.4, 0.03 * (expected - 0.4));
    const Pulled sprung = pull(cubes, {}, way);
    EXPECT_NEAR(length(sprung.after), 0.4, 1e-4);
    EXPECT_TRUE(sprung.after.plastic.empty());
}

TEST(BrickFlow, AStripOneCubeThickThatWasBentStaysBent)
{
    const Cubes cubes = box(16, 1, 2, 0.1, damped);
    const auto sag = [&](const PlasticOptions& plastic) {
        const State state = pull(cubes, plastic, Vec3(-0.2, -0.8, 0)).after;
        const auto end = corners_at_end(cubes, 0, End::high, 0);
        double sum = 0;
        for (const auto k : end) sum += cubes.corner_position(k).y() - state.x[k].y();
        return sum / double(end.size());
    };
    EXPECT_LT(std::abs(sag({})), 1e-5);
    EXPECT_LT(std::abs(sag({.yield = 0.2})), 1e-5);
    // Of 0.8 m: the further beyond the yield strain, the more.
    EXPECT_NEAR(sag({.yield = 0.05, .flow = 1e6}), 0.3, 0.1);
    EXPECT_NEAR(sag({.yield = 0.02, .flow = 1e6}), 0.75, 0.05);
}

TEST(BrickFlow, ABodyThatIsHeldStillFlowsOn)
{
    // Bent for twenty seconds, in most of which it would sleep.
    const Cubes cubes = box(8, 1, 1, 0.1, damped);
    const PlasticOptions slow{.yield = 1e-4, .flow = 0.02};
    const auto flowed_with = [&](bool sleep, int substeps) {
        const BricksBody body = make_bricks(cubes, {.plastic = slow});
        Loads loads;
        loads.forces.push_back({});
        loads.pins = pins_at(cubes, corners_at_end(cubes, 0, End::both, 0), Transform::Identity());
        for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
            if (loads.pins.target[p].x() > 0.4) loads.pins.target[p].y() += 0.02;
        }
        State state = rest_state(body);
        for (int i = 0; i < 480; ++i) {
            state = advance(
                body, std::move(state), loads, 1.0 / 24,
                {.substeps = substeps, .newton_iterations = 10, .tolerance = 1e-2, .sleep = sleep});
        }
        double sum = 0;
        for (const float each : state.plastic) sum += std::abs(double(each));
        return sum;
    };
    for (const int substeps : {1, 5}) {
        const double awake = flowed_with(false, substeps);
        EXPECT_GT(awake, 1e-4);
        EXPECT_NEAR(flowed_with(true, substeps), awake, 1e-6 * awake);
    }
}

TEST(BrickFlow, AStateIsACheckpoint)
{
    const Cubes cubes = box(6, 2, 2, 0.1, {.young = 2e5});
    const BricksBody body = make_bricks(cubes, {.plastic = {.yield = 0.01, .flow = 50}});
    Loads loads;
    loads.pins = pins_at(cubes, corners_at_end(cubes, 0, End::low, 0), Transform::Identity());
    loads.forces.push_back({});
    State state = rest_state(body);
    for (int i = 0; i < 10; ++i) state = advance(body, std::move(state), loads, 1.0 / 24);
    EXPECT_EQ(state.plastic.size(), plastic_rows * cubes.count());
    const BricksBody other = make_bricks(cubes, {.plastic = {.yield = 0.01, .flow = 50}});
    const State a = advance(body, state, loads, 1.0 / 24);
    const State b = advance(other, state, loads, 1.0 / 24);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.plastic, b.plastic);
    EXPECT_NE(a.plastic, state.plastic);
}

// A free bar that was drawn out by a tenth of its length swings, a second.
State swung(const Cubes& cubes, const BricksBody& body)
{
    State state = rest_state(body);
    for (Vec3& x : state.x) x.x() *= 1.1;
    for (int i = 0; i < 24; ++i) {
        state = advance(body, std::move(state), {}, 1.0 / 24,
                        {.integrator = Integrator::implicit_midpoint, .substeps = 4});
    }
    EXPECT_EQ(state.x.size(), cubes.corner_count());
    return state;
}

TEST(BrickFlow, TheMidpointRuleGivesNothingBackOfWhatFlowed)
{
    const Cubes cubes = box(6, 1, 1, 0.1, {.young = 1e5});
    const auto energy_of = [&](const BricksBody& body, const State& state) {
        return strain(body, state).energy + kinetic_energy(state, cubes);
    };
    const BricksBody elastic = make_bricks(cubes);
    State drawn = rest_state(elastic);
    for (Vec3& x : drawn.x) x.x() *= 1.1;
    const double start = energy_of(elastic, drawn);
    EXPECT_NEAR(energy_of(elastic, swung(cubes, elastic)), start, 1e-3 * start);
    const BricksBody yields = make_bricks(cubes, {.plastic = {.yield = 0.02, .flow = 1e6}});
    const State end = swung(cubes, yields);
    EXPECT_LT(energy_of(yields, end), 0.3 * start);
    // What the state tells of its energy is that of its rest shapes.
    double told = 0;
    for (const float each : end.energy) told += double(each);
    EXPECT_NEAR(strain(yields, end).energy, told, 1e-4 * start);
    EXPECT_GT(strain(yields, end.x).energy, 2 * told);
}

TEST(BrickFlow, RefusesOptionsThatMeanNothing)
{
    EXPECT_THROW(make_bricks(box(1, 1, 1, 0.1), {.plastic = {.yield = -1}}), std::invalid_argument);
    EXPECT_THROW(make_bricks(box(1, 1, 1, 0.1), {.plastic = {.limit = 1}}), std::invalid_argument);
}

TEST(BrickFlow, TellsTheStrainOfEachRestShape)
{
    const Cubes cubes = box(3, 1, 1, 0.1);
    EXPECT_TRUE(rest_state(make_bricks(cubes, {})).plastic_strain.empty());
    const BricksBody body = make_bricks(cubes, {.plastic = {.yield = 0.01}});
    EXPECT_EQ(rest_state(body).plastic_strain, std::vector<float>(3, 0.0f));
    BrickElasticity elasticity(body);
    EXPECT_EQ(elasticity.plastic_strain(), std::vector<float>(3, 0.0f));
    std::vector<float> plastic(plastic_rows * cubes.count(), 0.0f);
    plastic[0] = 0.3f, plastic[1] = 0.05f, plastic[3] = -0.1f;  // xx, xy and yx, yy
    plastic[plastic_rows + 6 + 9] = 0.3f;                       // along x by the monomial xyz
    elasticity.load_plastic(plastic);
    const auto told = elasticity.plastic_strain();
    ASSERT_EQ(told.size(), 3u);
    EXPECT_NEAR(told[0], std::sqrt(0.3 * 0.3 + 2 * 0.05 * 0.05 + 0.1 * 0.1), 1e-6);
    EXPECT_NEAR(told[1], 0.3 * std::sqrt(2.0) / 3, 1e-6);
    EXPECT_EQ(told[2], 0);
}

}  // namespace
