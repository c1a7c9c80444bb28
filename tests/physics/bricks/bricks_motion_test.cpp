// Bricks in motion: momentum, vibration, contact, and what no input may break.

#include "geometry/base/random.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/first_motion.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <cstring>
#include <numbers>

namespace {

using namespace physics;
using fixtures::finite;
using fixtures::shape_error;
using geometry::Cubes;
using geometry::Mat3;
using geometry::Random;
using geometry::Vec3;
using geometry::Vec3i;

Force gravity()
{
    return {};
}

Collider ground(double friction, double tilt = 0)
{
    Collider c;
    c.pose = geometry::Transform(Eigen::AngleAxisd(tilt, Vec3::UnitZ()));
    c.before = c.pose;
    c.friction = friction;
    return c;
}

Pins hold(const Cubes& cubes, const std::vector<std::uint32_t>& corners)
{
    Pins pins;
    pins.corner = corners;
    for (const auto k : corners) pins.target.push_back(cubes.corner_position(k));
    return pins;
}

TEST(BricksMotion, TheMidpointRuleConservesMomentum)
{
    // Both are quadratic invariants of a torque-free force: exact but for the solver's tolerance.
    const Cubes cubes = fixtures::box(3, 2, 2, 0.1, {.young = 1e4});
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    add_first_motion(state, cubes, Vec3(0.3, 0.1, -0.2), Vec3(2, 5, -3));
    const fixtures::BrickMotion before = fixtures::brick_motion(cubes, state);
    const StepOptions options{
        .integrator = Integrator::implicit_midpoint, .newton_iterations = 20, .tolerance = 1e-10};
    for (int i = 0; i < 20; ++i) state = advance(body, state, {}, 0.01, options);
    EXPECT_TRUE(state.report.converged);
    const fixtures::BrickMotion after = fixtures::brick_motion(cubes, state);
    EXPECT_LT((after.linear - before.linear).norm(), 1e-10 * before.linear.norm());
    EXPECT_LT((after.angular - before.angular).norm(), 1e-7 * before.angular.norm());
}

TEST(BricksMotion, EveryIntegratorKeepsLinearMomentum)
{
    const Cubes cubes = fixtures::blob(6, 30, 0.1, {.young = 1e4});
    const BricksBody body = make_bricks(cubes);
    for (const auto integrator :
         {Integrator::implicit_euler, Integrator::implicit_midpoint, Integrator::sdirk2}) {
        State state = rest_state(body);
        add_first_motion(state, cubes, Vec3(1, 0, 0), Vec3(2, 5, -3));
        const Vec3 before = fixtures::brick_motion(cubes, state).linear;
        for (int i = 0; i < 10; ++i) {
            state = advance(body, state, {}, 0.02, {.integrator = integrator, .tolerance = 1e-8});
        }
        EXPECT_LT((fixtures::brick_motion(cubes, state).linear - before).norm(),
                  1e-7 * before.norm());
    }
}

TEST(BricksMotion, AFreePartKeepsItsMomentumBesideOneThatIsHeld)
{
    // Two blocks side by side, whose corners are numbered row by row through both; the first is
    // held. Momentum of the other is right to rounding however loosely the step is solved.
    std::vector<Vec3i> cells;
    for (int i = 0; i < 54; ++i) cells.emplace_back(i % 6 + (i % 6 > 2), i / 6 % 3, i / 18);
    const Cubes cubes = fixtures::cubes_on(cells, 0.1, {.young = 1e4});
    const auto is_free = [](const Vec3i& corner) { return corner.x() > 3; };
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.pins =
        hold(cubes,
             fixtures::corners_where(cubes, [&](const Vec3i& corner) { return !is_free(corner); }));
    State state = rest_state(body);
    const auto mass = geometry::corner_masses(cubes);
    const auto linear = [&] {
        Vec3 sum = Vec3::Zero();
        for (std::size_t k = 0; k < mass.size(); ++k) {
            if (is_free(cubes.corner[k])) sum += mass[k] * state.v[k];
        }
        return sum;
    };
    add_first_motion(state, cubes, Vec3(0.3, 0.1, -0.2), Vec3(2, 5, -3));
    for (std::size_t k = 0; k < mass.size(); ++k) {
        state.v[k].x() += std::sin(30 * state.x[k].y());
        if (!is_free(cubes.corner[k])) state.v[k].setZero();
    }
    const Vec3 before = linear();
    for (int i = 0; i < 10; ++i) state = advance(body, state, loads, 0.02, {.tolerance = 0.1});
    EXPECT_LT((linear() - before).norm(), 1e-12 * before.norm());
}

// Axial vibration of a fixed-free bar of 10 cubes, nu = 0: f_1 = sqrt(E / rho) / (4 L).
double axial_frequency(Integrator integrator, double steps_a_period)
{
    const double young = 1e6, density = 1000, length = 1;
    const Cubes cubes =
        fixtures::box(10, 1, 1, 0.1, {.density = density, .young = young, .poisson = 0});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.pins =
        hold(cubes, fixtures::corners_where(cubes, [](const Vec3i& c) { return c.x() == 0; }));
    const double period = 4 * length / std::sqrt(young / density);
    State state = rest_state(body);
    for (Vec3& p : state.x) p.x() += 1e-4 * std::sin(std::numbers::pi / 2 * p.x());
    const double dt = period / steps_a_period;
    double last = 1, crossed = 0;
    int crossings = 0;
    for (int i = 1; crossings < 5 && i < 10 * steps_a_period; ++i) {
        state = advance(body, state, loads, dt, {.integrator = integrator, .tolerance = 1e-8});
        const double now = state.x.back().x() - 1;
        if (last > 0 && now <= 0) {
            const double at = (i - now / (now - last)) * dt;
            if (crossings++ == 0) crossed = at;
            if (crossings == 5) return 4 / (at - crossed) * period;
        }
        last = now;
    }
    return 0;
}

TEST(BricksMotion, TheFirstAxialFrequencyIsThatOfTheBar)
{
    // The mass of bricks raises it by (pi/2 h/L)^2 / 26 = 0.1 %; the midpoint rule lowers it by (2
    // pi/200)^2 / 12 = 0.01 %, sdirk2 by about as much.
    EXPECT_NEAR(axial_frequency(Integrator::implicit_midpoint, 200), 1, 2e-3);
    EXPECT_NEAR(axial_frequency(Integrator::sdirk2, 200), 1, 2e-3);
}

TEST(BricksMotion, IntegratorsConvergeAtTheirOrder)
{
    // A beam let go, after a tenth of a second, against many small steps.
    const Cubes cubes = fixtures::box(4, 1, 1, 0.1, {.young = 2e4});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back(gravity());
    loads.pins =
        hold(cubes, fixtures::corners_where(cubes, [](const Vec3i& c) { return c.x() == 0; }));
    const auto tip = [&](Integrator integrator, int steps) {
        return advance(body, rest_state(body), loads, 0.1,
                       {.integrator = integrator,
                        .substeps = steps,
                        .newton_iterations = 20,
                        .tolerance = 1e-9})
            .x.back()
            .y();
    };
    const double exact = tip(Integrator::sdirk2, 400);
    const auto order = [&](Integrator integrator) {
        return std::log2(std::abs(tip(integrator, 25) - exact) /
                         std::abs(tip(integrator, 50) - exact));
    };
    EXPECT_NEAR(order(Integrator::implicit_euler), 1, 0.15);
    EXPECT_NEAR(order(Integrator::implicit_midpoint), 2, 0.3);
    EXPECT_NEAR(order(Integrator::sdirk2), 2, 0.3);
}

TEST(BricksMotion, ABlockSlidesDownAnInclineAsCoulombSays)
{
    // Along the slope, a = g (sin t - mu cos t); below the angle of friction it stays.
    const double tilt = 0.5;
    Cubes cubes = fixtures::box(3, 1, 3, 0.1, {.young = 1e6, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes);
    const Mat3 turn = Eigen::AngleAxisd(tilt, Vec3::UnitZ()).toRotationMatrix();
    for (const double friction : {0.0, 0.3, 0.8}) {
        Loads loads;
        loads.forces.push_back(gravity());
        loads.colliders.push_back(ground(friction, tilt));
        State state = rest_state(body);
        for (Vec3& p : state.x) p = turn * p;
        std::vector<double> speed;
        Vec3 start = state.x[0];
        for (int i = 0; i < 60; ++i) {
            state = advance(body, state, loads, 0.01);
            Vec3 mean = Vec3::Zero();
            for (const Vec3& v : state.v) mean += v / double(state.v.size());
            speed.push_back(-(turn.transpose() * mean).x());
        }
        const double a = 9.81 * std::max(0.0, std::sin(tilt) - friction * std::cos(tilt));
        EXPECT_NEAR((speed[59] - speed[29]) / 0.3, a, 0.02 * 9.81) << friction;
        if (friction > std::tan(tilt)) {
            EXPECT_LT((state.x[0] - start).norm(), 0.01);
        }
    }
}

// Points come and go, stick and slip all the time; whole Newton steps alone go round in circles.
TEST(BricksMotion, ARoughLandingSettlesInEveryFrame)
{
    std::vector<Vec3i> cells;  // a table on four legs
    for (int x = 0; x < 7; ++x) {
        for (int z = 0; z < 7; ++z) cells.push_back(Vec3i(x, 4, z));
    }
    for (int y = 0; y < 4; ++y) {
        for (const auto& [x, z] :
             {std::pair(0, 0), std::pair(6, 0), std::pair(0, 6), std::pair(6, 6)}) {
            cells.push_back(Vec3i(x, y, z));
        }
    }
    const Cubes cubes = fixtures::cubes_on(cells, 0.05, {.young = 1e6, .stiffness_damping = 1e-3});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces = {gravity()};
    loads.colliders = {ground(0.5, 0.2)};
    State state = rest_state(body);
    const auto turn = Eigen::AngleAxisd(0.5, Vec3(1, 0, 1).normalized());
    for (Vec3& p : state.x) p = turn * p + Vec3(0, 0.3, 0);
    add_first_motion(state, cubes, Vec3(1, -2, 0.3), Vec3(0, 2, 1));
    for (int frame = 0; frame < 36; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 8});
        // One linearisation leaves forces over; what touches is found all the same.
        EXPECT_TRUE(state.report.warnings.empty()) << frame << ' ' << state.report.warnings[0];
    }
}

TEST(BricksMotion, AStackAtRestStaysAtRest)
{
    // Two blocks one above the other would be two bodies; here a column on three feet.
    std::vector<Vec3i> cells;
    for (int y = 1; y < 5; ++y)
        for (int x = 0; x < 3; ++x)
            for (int z = 0; z < 3; ++z) cells.emplace_back(x, y, z);
    cells.emplace_back(0, 0, 0), cells.emplace_back(2, 0, 0), cells.emplace_back(1, 0, 2);
    const Cubes cubes = fixtures::cubes_on(cells, 0.1, {.young = 1e6, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back(gravity());
    loads.colliders.push_back(ground(0.5));
    State state = rest_state(body);
    for (int i = 0; i < 150; ++i) state = advance(body, state, loads, 1.0 / 24);
    double fastest = 0, deepest = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        fastest = std::max(fastest, state.v[k].norm());
        deepest = std::max(deepest, -state.x[k].y());
    }
    EXPECT_LT(fastest, 1e-4);
    // Weight on the feet: 39 cubes over 3, 13 rho g h = 12.8 kPa; a layer of ten times the material
    // gives h sigma / 10 E = 1.3e-4 m, more under the foot that bears more.
    EXPECT_LT(deepest, 5e-4);
}

// The factor of the step's matrix has the contacts in it. Without them it took 1,942 iterations.
TEST(BricksMotion, AStiffPlateThatFallsFlatTakesFewIterations)
{
    Cubes cubes = fixtures::box(20, 1, 20, 0.1, {.young = 1e8, .stiffness_damping = 0.001});
    cubes.origin.y() = 0.2;
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back(gravity());
    loads.colliders.push_back(ground(0.5));
    State state = rest_state(body);
    state.v.assign(state.v.size(), Vec3(0.3, -1, 0.1));
    int most = 0;
    for (int i = 0; i < 12; ++i) {
        state = advance(body, state, loads, 1.0 / 24);
        most = std::max(most, state.report.iterations);
    }
    EXPECT_GT(most, 10);
    EXPECT_LT(most, 200);
}

TEST(BricksMotion, ADroppedBallNeverGainsEnergy)
{
    std::vector<Vec3i> cells;
    for (int x = -3; x < 3; ++x)
        for (int y = -3; y < 3; ++y)
            for (int z = -3; z < 3; ++z)
                if (Vec3(x + 0.5, y + 0.5, z + 0.5).norm() < 3) cells.emplace_back(x, y, z);
    Cubes cubes = fixtures::cubes_on(cells, 0.1, {.young = 5e4});
    cubes.origin.y() = 0.7;
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back(gravity());
    loads.colliders.push_back(ground(0.3));
    State state = rest_state(body);
    const auto mass = corner_masses(cubes);
    const auto energy = [&] {
        double e = strain(body, state.x).energy + fixtures::brick_motion(cubes, state).energy;
        for (std::size_t k = 0; k < mass.size(); ++k) e += mass[k] * 9.81 * state.x[k].y();
        return e;
    };
    double last = energy(), lowest = 1;
    const double start = last;
    for (int i = 0; i < 100; ++i) {
        state = advance(body, state, loads, 0.01);
        const double now = energy();
        EXPECT_LT(now, last + 1e-3 * start) << i;
        last = now;
        for (const Vec3& p : state.x) lowest = std::min(lowest, p.y());
    }
    EXPECT_GT(lowest, -0.02);  // a fifth of a cube
}

TEST(BricksMotion, TwistedStretchedMirroredAndCollapsedBodiesComeBack)
{
    const Cubes cubes =
        fixtures::box(4, 2, 2, 0.1, {.young = 1e5, .mass_damping = 4, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes);
    const Random random(12);
    using Deform = std::function<Vec3(const Vec3&, std::uint64_t)>;
    const std::vector<std::pair<const char*, Deform>> cases{
        {"twisted",
         [](const Vec3& p, auto) {
             return Vec3(Eigen::AngleAxisd(4 * std::numbers::pi * p.x() / 0.4, Vec3::UnitX()) * p);
         }},
        {"stretched", [](const Vec3& p, auto) { return Vec3(10 * p.x(), p.y(), p.z()); }},
        {"mirrored", [](const Vec3& p, auto) { return Vec3(-p.x(), p.y(), p.z()); }},
        {"flat", [](const Vec3& p, auto) { return Vec3(p.x(), 0, p.z()); }},
        {"a line", [](const Vec3& p, auto) { return Vec3(p.x(), 0, 0); }},
        {"a point", [](const Vec3&, auto) { return Vec3(0.1, 0.2, 0.3); }},
        {"random", [&](const Vec3&, std::uint64_t k) {
             return Vec3(random.unit(3 * k), random.unit(3 * k + 1), random.unit(3 * k + 2));
         }}};
    for (const auto& [name, deform] : cases) {
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.x.size(); ++k) state.x[k] = deform(state.x[k], k);
        for (int i = 0; i < 200; ++i) {
            state = advance(body, state, {}, 0.02);
            ASSERT_TRUE(finite(state)) << name << ' ' << i;
        }
        // Random corners may settle wound through themselves, with no cube inside out: a place of
        // least energy like any other, which only contact of the body with itself would forbid.
        if (name == std::string("random")) {
            for (const Vec3& v : state.v) EXPECT_LT(v.norm(), 1e-5);
        } else {
            EXPECT_LT(shape_error(cubes, state), 1e-3 * 0.4) << name;
            EXPECT_TRUE(state.report.warnings.empty()) << name;
        }
    }
}

TEST(BricksMotion, NoStepLengthAndNoStiffnessGivesANaN)
{
    Cubes cubes = fixtures::box(4, 2, 1, 0.1, {.young = 1e5, .poisson = 0.499});
    for (std::size_t c = 0; c < cubes.count(); c += 2) cubes.young[c] = 1e11;
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back(gravity());
    loads.pins =
        hold(cubes, fixtures::corners_where(cubes, [](const Vec3i& c) { return c.x() == 0; }));
    const Random random(3);
    for (const double dt : {1e-6, 1e-3, 1.0 / 24, 1.0, 10.0}) {
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            state.x[k] += 0.03 * Vec3(random.unit(3 * k), random.unit(3 * k + 1), 0);
        }
        for (int i = 0; i < 10; ++i) state = advance(body, state, loads, dt);
        ASSERT_TRUE(finite(state)) << dt;
    }
}

TEST(BricksMotion, AllPinnedNonePinnedAndOneCube)
{
    const Cubes one = fixtures::box(1, 1, 1, 0.1);
    const BricksBody body = make_bricks(one);
    Loads loads;
    loads.forces.push_back(gravity());
    loads.pins = hold(one, fixtures::corners_where(one, [](const Vec3i&) { return true; }));
    for (Vec3& p : loads.pins.target) p.x() += 0.5;
    State state = advance(body, rest_state(body), loads, 0.1, {.substeps = 4});
    for (std::uint32_t k = 0; k < 8; ++k) {
        EXPECT_EQ(state.x[k], loads.pins.target[k]);
        EXPECT_TRUE(state.v[k].isApprox(Vec3(5, 0, 0), 1e-12));
    }
    loads.pins = {};
    state = advance(body, rest_state(body), loads, 0.1);
    for (const Vec3& v : state.v) EXPECT_NEAR(v.y(), -0.981, 1e-6);
    EXPECT_THROW(make_bricks(Cubes{}), std::invalid_argument);
}

TEST(BricksMotion, BadInputIsRefusedByName)
{
    const Cubes cubes = fixtures::box(2, 1, 1, 0.1);
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    EXPECT_THROW(advance(body, state, {}, 0), std::invalid_argument);
    EXPECT_THROW(advance(body, state, {}, std::nan("")), std::invalid_argument);
    State broken = state;
    broken.x[3].y() = std::nan("");
    EXPECT_THROW(advance(body, broken, {}, 0.1), std::invalid_argument);
    broken = state;
    broken.x.pop_back();
    EXPECT_THROW(advance(body, broken, {}, 0.1), std::invalid_argument);
    Loads loads;
    loads.pins.corner = {99};
    loads.pins.target = {Vec3::Zero()};
    EXPECT_THROW(advance(body, state, loads, 0.1), std::invalid_argument);
    loads = {};
    loads.forces.push_back({.acceleration = Vec3(0, std::nan(""), 0)});
    EXPECT_THROW(advance(body, state, loads, 0.1), std::invalid_argument);
    Cubes bad = cubes;
    bad.young[1] = std::nan("");
    EXPECT_THROW(make_bricks(bad), std::invalid_argument);
    bad = cubes;
    bad.poisson[0] = 0.5;
    EXPECT_THROW(make_bricks(bad), std::invalid_argument);
}

TEST(BricksMotion, AnyNumberOfThreadsGivesTheSameBytes)
{
    // Large enough that pieces, sums and fronts are shared out.
    const Cubes solid = fixtures::box(17, 17, 15, 0.05, {.young = 1e4});
    const Cubes slender = fixtures::box(270, 4, 4, 0.05, {.young = 1e5});
    for (const Cubes& cubes : {solid, slender}) {
        const auto run = [&](std::size_t threads) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            const BricksBody body = make_bricks(cubes);
            Loads loads;
            loads.forces.push_back(gravity());
            loads.colliders.push_back(ground(0.5));
            loads.pins = hold(
                cubes, fixtures::corners_where(cubes, [](const Vec3i& c) { return c.x() == 0; }));
            return advance(body, rest_state(body), loads, 0.02, {.tolerance = 1e-2});
        };
        const State one = run(1);
        for (const std::size_t threads : {2u, 8u}) {
            const State many = run(threads);
            EXPECT_EQ(std::memcmp(one.x.data(), many.x.data(), one.x.size() * sizeof(Vec3)), 0);
            EXPECT_EQ(std::memcmp(one.v.data(), many.v.data(), one.v.size() * sizeof(Vec3)), 0);
            EXPECT_EQ(one.stress, many.stress);
        }
    }
}

TEST(BricksMotion, WindPushesAPlateByItsFrontalArea)
{
    // 1/2 rho C A u^2 at rest: A = 0.2 x 0.3.
    const Cubes cubes = fixtures::box(1, 2, 3, 0.1);
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    Force wind;
    wind.kind = Force::Kind::wind;
    wind.velocity = Vec3(10, 0, 0);
    loads.forces.push_back(wind);
    const double dt = 1e-4;
    const State state = advance(body, rest_state(body), loads, dt, {.tolerance = 1e-6});
    EXPECT_NEAR(fixtures::brick_motion(cubes, state).linear.x() / dt, 0.5 * 1.2 * 0.06 * 100, 1e-3);
}

TEST(BricksMotion, AVelocityBeyondNumbersIsRefused)
{
    const Cubes cubes = fixtures::box(2, 1, 1, 0.1);
    State state = rest_state(make_bricks(cubes));
    add_first_motion(state, cubes, Vec3(1.7e308, 0, 0), Vec3::Zero());
    EXPECT_THROW(add_first_motion(state, cubes, Vec3(1.7e308, 0, 0), Vec3::Zero()),
                 std::invalid_argument);
}

}  // namespace
