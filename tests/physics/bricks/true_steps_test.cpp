// Steps that mean what they report: more rounds of Newton's method reach the solution of the
// non-linear equations, stay there, and say so only where they did.

#include "geometry/base/random.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/elastic_energy.hpp"
#include "physics/state/first_motion.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using namespace physics;
using fixtures::brick_motion;
using fixtures::BrickMotion;
using fixtures::shape_error;
using geometry::Cubes;
using geometry::Random;
using geometry::Vec3i;

// A cantilever of 20 cubes with a dead load P across its tip, alpha = P L^2 / (E I).
struct Elastica {
    static constexpr int length = 20;
    static constexpr double young = 1e8, h = 1;
    Cubes cubes = fixtures::box(length, 1, 1, h, {.young = young, .poisson = 0});
    BricksBody body = make_bricks(cubes);
    std::vector<std::uint32_t> tip =
        fixtures::corners_where(cubes, [](const Vec3i& c) { return c.x() == length; });
    Loads loads;

    explicit Elastica(double alpha)
    {
        loads.pins.corner = fixtures::first_layer(cubes);
        for (const auto k : loads.pins.corner) {
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        const double load = alpha * young * (h * h * h * h / 12) / (length * length);
        for (const auto k : tip) {
            Force f;
            f.kind = Force::Kind::point;
            f.position = cubes.corner_position(k);
            f.radius = 0;
            f.force = Vec3(0, -load / double(tip.size()), 0);
            loads.forces.push_back(f);
        }
    }
    // Shortening and deflection as shares of the length.
    std::pair<double, double> at(const State& state) const
    {
        Vec3 mean = Vec3::Zero();
        for (const auto k : tip) mean += state.x[k] / double(tip.size());
        return {1 - mean.x() / length, (0.5 - mean.y()) / length};
    }
};

TEST(TrueSteps, AnElasticaIsFoundInOneFrame)
{
    // Frisch-Fay. Flexible bars. 1962; u and w of the inextensible beam. At alpha = 10 a beam of
    // this thickness bends 4.5 degrees a cube.
    struct Case {
        double alpha, u, w;
    };
    for (const auto& [alpha, u, w] :
         {Case{0.5, 0.0159190, 0.1621436}, Case{1, 0.0564332, 0.3017208},
          Case{2, 0.1606417, 0.4934575}, Case{5, 0.3876284, 0.7137915},
          Case{10, 0.5549956, 0.8106090}}) {
        const Elastica e(alpha);
        const State state = advance(e.body, rest_state(e.body), e.loads, 1e4,
                                    {.newton_iterations = 50, .tolerance = 1e-6});
        EXPECT_TRUE(state.report.converged) << alpha;
        EXPECT_NEAR(e.at(state).first, u, 0.01 * u) << alpha;
        EXPECT_NEAR(e.at(state).second, w, 0.01 * w) << alpha;
    }
}

TEST(TrueSteps, AnElasticaUnderAStaticLoadStaysForAThousandFrames)
{
    const Elastica e(10);
    const StepOptions options{.newton_iterations = 20};
    State state = rest_state(e.body);
    for (int i = 0; i < 100; ++i) state = advance(e.body, state, e.loads, 1, options);
    const State settled = state;
    EXPECT_NEAR(e.at(settled).second, 0.8106090, 0.01 * 0.8106090);
    for (int i = 0; i < 1000; ++i) {
        state = advance(e.body, state, e.loads, 1.0 / 24, options);
        ASSERT_TRUE(state.report.converged) << i;
    }
    // The tolerance, 1e-4 of the load, moves the tip by about as much of its deflection.
    EXPECT_NEAR(e.at(state).first, e.at(settled).first, 2e-4);
    EXPECT_NEAR(e.at(state).second, e.at(settled).second, 2e-4);
}

// A ground far below the body.
Loads over_far_ground(Loads loads = {})
{
    Collider ground;
    ground.pose.translation() = ground.before.translation() = Vec3(0, -1000, 0);
    loads.colliders.push_back(ground);
    return loads;
}

TEST(TrueSteps, GroundThatIsNotTouchedChangesNothing)
{
    // More rounds, and a search for an equilibrium's worth of time, are as true above a ground.
    const Elastica e(10);
    const StepOptions options{.newton_iterations = 50, .tolerance = 1e-6};
    const State without = advance(e.body, rest_state(e.body), e.loads, 1e4, options);
    const State with = advance(e.body, rest_state(e.body), over_far_ground(e.loads), 1e4, options);
    EXPECT_TRUE(with.report.converged);
    EXPECT_TRUE(with.report.warnings.empty());
    for (std::size_t k = 0; k < with.x.size(); ++k) ASSERT_EQ(with.x[k], without.x[k]);
}

TEST(TrueSteps, NoStepThatIsWrongSaysThatItConverged)
{
    // Fifty steps of a beam thrown about, of all lengths and with any number of rounds, against the
    // same step solved to 1e-9. Each is told to 1e-3 of the forces.
    const Cubes cubes = fixtures::box(6, 2, 1, 0.1, {.young = 1e5, .stiffness_damping = 1e-3});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.pins.corner = fixtures::first_layer(cubes);
    for (const auto k : loads.pins.corner) loads.pins.target.push_back(cubes.corner_position(k));
    const Random random(7);
    int wrong = 0, right = 0;
    State state = rest_state(body);
    for (std::uint64_t i = 0; i < 50; ++i) {
        State from = state;
        for (std::size_t k = 0; k < from.v.size(); ++k) {
            from.v[k] += 3.0 * Vec3(0, random.unit(100 * i) - 0.5, random.unit(100 * i + 1) - 0.5) *
                         from.x[k].x();
        }
        const double dt = std::pow(10, -3 + 3 * random.unit(100 * i + 2));
        const int rounds = 1 + int(random.bits(100 * i + 3) % 6);
        const State step =
            advance(body, from, loads, dt, {.newton_iterations = rounds, .tolerance = 1e-3});
        const State exact =
            advance(body, from, loads, dt, {.newton_iterations = 100, .tolerance = 1e-9});
        ASSERT_TRUE(exact.report.converged) << i;
        double error_sq = 0, moved_sq = 0;
        for (std::size_t k = 0; k < step.x.size(); ++k) {
            error_sq += (step.x[k] - exact.x[k]).squaredNorm();
            moved_sq += (exact.x[k] - from.x[k]).squaredNorm();
        }
        const bool off = error_sq > 1e-4 * moved_sq;  // by ten times the tolerance
        if (off) {
            EXPECT_FALSE(step.report.converged)
                << i << ' ' << std::sqrt(error_sq / moved_sq) << ' ' << step.report.residual;
        }
        wrong += off ? 1 : 0;
        right += step.report.converged ? 1 : 0;
        state = exact;
    }
    EXPECT_GT(wrong, 5);  // there was something to find
    EXPECT_GT(right, 15);
}

TEST(TrueSteps, AFreeSpinKeepsItsEnergyAndAngularMomentum)
{
    // 300 degrees a second for 10 s, 12.5 degrees a step. What spins is stretched by
    // rho w^2 L^2 / 8 E, 2e-4 at 1e6 Pa: as much energy as goes with it is no loss.
    struct Case {
        int length;
        double young;
        Vec3 axis;
    };
    for (const auto& [length, young, axis] :
         {Case{4, 1e6, Vec3(0, 1, 0)}, Case{2, 1e6, Vec3(1, 0, 0)}, Case{3, 1e7, Vec3(1, 2, 3)},
          Case{1, 1e9, Vec3(3, 2, 1)}}) {
        const Cubes cubes = fixtures::box(length, 2, 2, 0.1, {.young = young});
        const BricksBody body = make_bricks(cubes);
        for (const int rounds : {1, 10}) {
            State state = rest_state(body);
            add_first_motion(state, cubes, Vec3::Zero(),
                             300 * std::numbers::pi / 180 * axis.normalized());
            const BrickMotion before = brick_motion(cubes, state);
            for (int i = 0; i < 240; ++i) {
                state = advance(body, state, {}, 1.0 / 24, {.newton_iterations = rounds});
            }
            const BrickMotion after = brick_motion(cubes, state);
            EXPECT_NEAR(after.energy, before.energy, 0.01 * before.energy) << length;
            EXPECT_LT((after.angular - before.angular).norm(), 1e-9 * before.angular.norm());
            EXPECT_LT(shape_error(cubes, state), 1e-3 * 0.4) << length;
        }
    }
}

TEST(TrueSteps, TheMidpointRuleGainsNoEnergyAndSaysWhatItDidInstead)
{
    // In steps of 12.5 degrees the rule alone makes 1.6e3 times the energy in 40 frames; in 32
    // times as many steps it holds by itself.
    const Cubes cubes = fixtures::box(4, 2, 2, 0.1, {.young = 1e6});
    const BricksBody body = make_bricks(cubes);
    for (const int substeps : {1, 32}) {
        for (const Loads& loads : {Loads{}, over_far_ground()}) {
            State state = rest_state(body);
            add_first_motion(state, cubes, Vec3::Zero(), Vec3(0, 300 * std::numbers::pi / 180, 0));
            const BrickMotion before = brick_motion(cubes, state);
            int told = 0;
            const int frames = substeps == 1 ? 240 : 24;
            for (int i = 0; i < frames; ++i) {
                state =
                    advance(body, state, loads, 1.0 / 24,
                            {.integrator = Integrator::implicit_midpoint, .substeps = substeps});
                told += state.report.warnings.empty() ? 0 : 1;
            }
            const BrickMotion after = brick_motion(cubes, state);
            EXPECT_NEAR(after.energy, before.energy, 0.01 * before.energy) << substeps;
            EXPECT_LT((after.angular - before.angular).norm(), 1e-9 * before.angular.norm());
            EXPECT_EQ(told > 0, substeps == 1);
        }
    }
}

// J, of motion and of gravity.
double with_height(const Cubes& cubes, const State& state)
{
    double height = 0;
    const std::vector<double> mass = geometry::corner_masses(cubes);
    for (std::size_t k = 0; k < mass.size(); ++k) height += 9.81 * mass[k] * state.x[k].y();
    return brick_motion(cubes, state).energy + height;
}

// A stiff box that begins with a spin and goes on by the midpoint rule, on or above a ground: for
// ten seconds it has at most `share` more than the energy of its spin and of its fall to the
// ground.
void gains_nothing_on(const Collider& ground, const Vec3& spin, double share)
{
    const Cubes cubes = fixtures::box(4, 2, 2, 0.1, {.young = 1e6});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back(ground);
    State state = rest_state(body);
    add_first_motion(state, cubes, Vec3::Zero(), spin);
    const double before = with_height(cubes, state);
    const double fall =
        9.81 * geometry::total_mass(cubes) * std::abs(ground.pose.translation().y());
    const double most = before + share * (brick_motion(cubes, state).energy + fall);
    for (int i = 0; i < 240; ++i) {
        state =
            advance(body, state, loads, 1.0 / 24, {.integrator = Integrator::implicit_midpoint});
        ASSERT_LT(with_height(cubes, state), most) << i;
    }
}

// Forces that are linear about where a step began stretch what turns in it, and a stiff box holds
// far more energy then than it came with: 2,500 times, without halving such steps.
TEST(TrueSteps, AStiffBoxThatLandsGainsNoEnergy)
{
    const Cubes cubes = fixtures::box(6, 2, 2, 0.1, {.young = 1e10});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.resize(1);
    loads.colliders[0].friction = 0.4;
    State state = rest_state(body);
    const Eigen::AngleAxisd tilt(0.7, Vec3(0.3, 0.2, 1).normalized());
    for (Vec3& x : state.x) x = tilt * x + Vec3(0, 0.5, 0);
    for (Vec3& v : state.v) v = Vec3(0, -3, 0);
    const double before = with_height(cubes, state);
    for (int i = 0; i < 24; ++i) {
        state = advance(body, state, loads, 1.0 / 24);
        EXPECT_LT(with_height(cubes, state) + elastic_energy(body, state), 1.1 * before) << i;
    }
}

TEST(TrueSteps, TheMidpointRuleGainsNoEnergyOnTheGround)
{
    // It falls on its corner, tumbles and slides.
    Collider ground;
    ground.friction = 0.3;
    ground.pose.translation() = ground.before.translation() = Vec3(0, -0.3, 0);
    gains_nothing_on(ground, Vec3(1, 4, 2), 0.05);
}

TEST(TrueSteps, TheMidpointRuleGainsNoEnergyOnIce)
{
    // It spins flat. With one linearisation a step, 3.7 J become 18 in a second.
    Collider ice;
    ice.friction = 0;
    gains_nothing_on(ice, Vec3(0, 300 * std::numbers::pi / 180, 0), 0.05);
}

TEST(TrueSteps, ABrickTumblesForThousandsOfStepsWithoutATrend)
{
    // About its middle axis, where a rigid body turns over again and again.
    const Cubes cubes = fixtures::box(1, 2, 3, 0.1, {.young = 1e8});
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    add_first_motion(state, cubes, Vec3::Zero(), Vec3(0.05, 5, 0.05));
    const BrickMotion before = brick_motion(cubes, state);
    double along = 1;
    for (int i = 0; i < 2000; ++i) {
        state = advance(body, state, {}, 1.0 / 24);
        along = std::min(along, (state.x.back() - state.x.front()).normalized().y());
    }
    EXPECT_LT(along, -0.3);  // it did turn over
    const BrickMotion after = brick_motion(cubes, state);
    EXPECT_NEAR(after.energy, before.energy, 1e-3 * before.energy);
    EXPECT_LT((after.angular - before.angular).norm(), 1e-9 * before.angular.norm());
}

// Bars that spin about their axis of most inertia, up to 75 degrees a step: it is where they have
// the least energy for their angular momentum, so that they stay with it.
TEST(TrueSteps, AFlatBarStaysWithItsAxisInLongSteps)
{
    const Cubes cubes = fixtures::box(10, 3, 1, 0.04, {.young = 1e8});
    const BricksBody body = make_bricks(cubes);
    for (const double a_step : {30.0, 60.0, 75.0}) {
        for (const int substeps : {1, 0}) {
            State state = rest_state(body);
            add_first_motion(state, cubes, Vec3::Zero(),
                             Vec3(0, 0, 24 * a_step * std::numbers::pi / 180));
            const BrickMotion before = brick_motion(cubes, state);
            for (int i = 0; i < 48; ++i) {
                state = advance(body, state, {}, 1.0 / 24, {.substeps = substeps});
                ASSERT_TRUE(state.report.warnings.empty()) << state.report.warnings[0];
            }
            const BrickMotion after = brick_motion(cubes, state);
            EXPECT_NEAR(after.energy, before.energy, 0.01 * before.energy) << a_step;
            EXPECT_LT((after.angular - before.angular).norm(), 1e-9 * before.angular.norm());
            EXPECT_LT(shape_error(cubes, state), 1e-2 * 0.4) << a_step;
        }
    }
}

TEST(TrueSteps, AThrownBodyDoesNotBeginToSpin)
{
    const Cubes cubes = fixtures::box(4, 2, 1, 0.1, {.young = 1e6});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    for (const Integrator integrator :
         {Integrator::implicit_euler, Integrator::implicit_midpoint}) {
        State state = rest_state(body);
        for (Vec3& v : state.v) v = Vec3(5, 3, -2);
        for (int i = 0; i < 48; ++i) {
            state = advance(body, state, loads, 1.0 / 24,
                            {.integrator = integrator, .tolerance = 1e-9});
        }
        const Vec3 along = state.x.back() - state.x.front();
        const Vec3 rest = cubes.corner_position(state.x.size() - 1) - cubes.corner_position(0);
        EXPECT_LT((along - rest).norm(), 1e-9 * rest.norm());
    }
}

}  // namespace
