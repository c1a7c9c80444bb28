#include "physics/lattice/lattice.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/choose_corners.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/every_target.hpp"
#include "tests/physics/state_measures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numbers>

using namespace physics;
using fixtures::box;
using fixtures::first_layer;
using fixtures::misfit;
using geometry::Cubes;
using geometry::Mat3;
using geometry::Random;

namespace {

LatticeOptions stiffest(int substeps = 1, Precision precision = Precision::single)
{
    return {.stiffness = Stiffness::rate,
            .rate = std::numeric_limits<double>::infinity(),
            .damping = 0,
            .substeps = substeps,
            .precision = precision};
}

LatticeBody lattice_of(const Cubes& cubes, int w)
{
    return make_lattice(cubes, {.half_width = w});
}

// An L of cubes with a prong: no symmetry to hide behind.
Cubes crooked()
{
    std::vector<geometry::Vec3i> cells;
    for (int x = 0; x < 6; ++x) {
        for (int y = 0; y < 2; ++y) cells.emplace_back(x, y, 0), cells.emplace_back(x, y, 1);
    }
    for (int y = 2; y < 6; ++y) cells.emplace_back(0, y, 0), cells.emplace_back(2, y, 0);
    return fixtures::cubes_on(cells, 0.1);
}

struct Momenta {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
    double size = 0;  // sum of m |v|, and of m |x| |v|
};
Momenta momenta(const LatticeBody& body, const State& state)
{
    Momenta sum;
    for (std::size_t i = 0; i < state.x.size(); ++i) {
        const double m = body.base.mass[i];
        sum.linear += m * state.v[i];
        sum.angular += m * state.x[i].cross(state.v[i]);
        sum.size += m * state.v[i].norm();
    }
    return sum;
}

double centre_of(const State& state, int axis)
{
    double sum = 0;
    for (const Vec3& x : state.x) sum += x[axis];
    return sum / double(state.x.size());
}

}  // namespace

TEST(Lattice, ABodyAtRestUnderAnyRigidMotionStaysThere)
{
    for (const int w : {1, 2, 3}) {
        const LatticeBody body = lattice_of(crooked(), w);
        for (const Precision precision : {Precision::single, Precision::full}) {
            State state = rest_state(body);
            const Eigen::Quaterniond turn(Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()));
            for (auto& x : state.x) x = turn * x + Vec3(5, 6, 7);
            const State before = state;
            state = advance(body, state, {}, 0.01, stiffest(1, precision));
            double worst = 0;
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                worst = std::max(worst, (state.x[i] - before.x[i]).norm());
            }
            // Rounding of places within 0.6 m of the middle, some regions' width deep.
            EXPECT_LT(worst, precision == Precision::single ? 3e-6 : 1e-14);
            // What every region starts the next step from.
            for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
                if (body.whole.regions.particle[s] == none) continue;
                const float* const q = state.rotation.data() + 4 * s;
                EXPECT_NEAR(
                    std::abs(turn.cast<float>().dot(Eigen::Quaternionf(q[0], q[1], q[2], q[3]))), 1,
                    1e-5);
            }
        }
    }
}

TEST(Lattice, ASteadySpinStaysASpinWithoutDamping)
{
    // Regions turn with the body: a small step of a rigid spin finds goals where particles go.
    const LatticeBody body = lattice_of(crooked(), 2);
    State state = rest_state(body);
    const Vec3 spin(0, 0, 2);
    for (std::size_t i = 0; i < state.x.size(); ++i) state.v[i] = spin.cross(state.x[i]);
    const double before = momenta(body, state).angular.z();
    for (int frame = 0; frame < 60; ++frame)
        state = advance(body, state, {}, 1.0 / 60, stiffest(8));
    EXPECT_NEAR(momenta(body, state).angular.z(), before, 1e-9 * before);
    EXPECT_LT(misfit(rest_state(body), state), 0.02 * 0.6);
}

TEST(Lattice, KeepsMomentumToRounding)
{
    const Random random(2);
    for (const Precision precision : {Precision::single, Precision::full}) {
        const LatticeBody body = lattice_of(crooked(), 2);
        State state = rest_state(body);
        for (std::size_t i = 0; i < state.x.size(); ++i) {
            for (int d = 0; d < 3; ++d) {
                state.x[i][d] += 0.05 * (random.unit(6 * i + std::uint64_t(d)) - 0.5);
                state.v[i][d] = random.unit(6 * i + 3 + std::uint64_t(d)) - 0.3;
            }
        }
        const Momenta before = momenta(body, state);
        LatticeOptions options = stiffest(4, precision);
        options.damping = 1;
        for (int frame = 0; frame < 25; ++frame) state = advance(body, state, {}, 0.02, options);
        const Momenta after = momenta(body, state);
        // 100 steps of rounding in double, whatever the sums over regions are made in.
        EXPECT_LT((after.linear - before.linear).norm(), 1e-12 * before.size);
        EXPECT_LT((after.angular - before.angular).norm(), 1e-11 * before.size);
    }
}

TEST(Lattice, RecoversFromAnyDeformation)
{
    // All at one point, on a line, on a plane, mirrored, at random: back to the rest shape within a
    // thousandth of its size (0.85 m), up to a rigid motion.
    const Cubes cubes = box(5, 4, 3, 0.1);
    const Random random(3);
    using Move = std::function<Vec3(const Vec3&, std::uint64_t)>;
    const std::vector<std::pair<std::string, Move>> cases = {
        {"a point", [](const Vec3&, std::uint64_t) { return Vec3(1, 2, 3); }},
        {"a line", [](const Vec3& x, std::uint64_t) { return Vec3(x[0], 0, 0); }},
        {"a plane", [](const Vec3& x, std::uint64_t) { return Vec3(x[0], 0, x[2]); }},
        {"mirrored", [](const Vec3& x, std::uint64_t) { return Vec3(-x[0], x[1], x[2]); }},
        {"inside out", [](const Vec3& x, std::uint64_t) { return Vec3(-x); }},
        {"random",
         [&](const Vec3&, std::uint64_t i) {
             return Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2));
         }},
    };
    for (const int w : {1, 2}) {
        const LatticeBody body = lattice_of(cubes, w);
        for (const auto& [name, move] : cases) {
            State state = rest_state(body);
            for (std::size_t i = 0; i < state.x.size(); ++i) state.x[i] = move(state.x[i], i);
            LatticeOptions options = stiffest(10);
            options.damping = 1;
            for (int frame = 0; frame < 150; ++frame) {
                state = advance(body, state, {}, 0.1, options);
            }
            EXPECT_LT(misfit(rest_state(body), state), 1e-3 * 0.7) << name << ", w = " << w;
        }
    }
}

TEST(Lattice, AnyStepAndAnyStiffnessIsFinite)
{
    const Cubes cubes = crooked();
    const LatticeBody body = lattice_of(cubes, 2);
    Loads loads;
    loads.forces.push_back({});
    loads.pins.corner = {0};
    loads.pins.target = {Vec3::Zero()};
    for (const double dt : {1e-3, 0.1, 10.0}) {
        for (const double rate : {0.0, 1.0, 1e6, std::numeric_limits<double>::infinity()}) {
            State state = rest_state(body);
            LatticeOptions options = stiffest();
            options.rate = rate;
            options.damping = 1e-3;
            for (int frame = 0; frame < 200; ++frame) {
                state = advance(body, state, loads, dt, options);
                ASSERT_TRUE(state.report.converged);
            }
            for (const Vec3& x : state.x) ASSERT_TRUE(x.allFinite());
        }
    }
}

TEST(Lattice, AnAxialWaveHasTheMaterialsSpeed)
{
    // A bar fixed at one end, poisson 0, pulled and let go: period 4 L / sqrt(E / rho). Shape
    // matching averages over regions, so short waves are slow: L = 40 cubes, w = 1 and 2. The
    // regions at the ends are half as long: an error of the order of 2 w / 40.
    const double h = 0.025, length = 1;
    const Cubes cubes = box(40, 2, 2, h, {1000, 1e5, 0});
    const double period = 4 * length / std::sqrt(1e5 / 1000);
    for (const int w : {1, 2}) {
        const LatticeBody body =
            make_lattice(cubes, {.half_width = w, .calibrate = Calibration::stretch});
        State state = rest_state(body);
        Loads loads;
        for (const auto k : first_layer(cubes)) {
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(state.x[k]);
        }
        for (auto& x : state.x) x[0] += 0.01 * std::sin(std::numbers::pi / 2 * x[0] / length);
        const double rest = 0.5 + 0;
        LatticeOptions options{.damping = 0, .substeps = 1, .precision = Precision::full};
        const double dt = period / 800;
        // The first return to the rest length is a quarter of a period after.
        int steps = 0;
        while (centre_of(state, 0) > rest && steps < 1000) {
            state = advance(body, state, loads, dt, options);
            ++steps;
        }
        EXPECT_NEAR(steps / 200.0, 1, 0.05 * w) << w;
    }
}

TEST(Lattice, MotionDoesNotDependOnTheStep)
{
    // The same material, one fine and one four times coarser step: the same swing within a few
    // per cent of its size.
    const Cubes cubes = box(12, 2, 2, 0.1, {1000, 2e5, 0.3});
    const LatticeBody body = lattice_of(cubes, 2);
    Loads loads;
    loads.forces.push_back({});
    State start = rest_state(body);
    for (const auto k : first_layer(cubes)) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(start.x[k]);
    }
    const auto swing = [&](int substeps) {
        State state = start;
        LatticeOptions options{.damping = 0, .substeps = substeps};
        for (int frame = 0; frame < 12; ++frame) {
            state = advance(body, state, loads, 1.0 / 24, options);
        }
        return state.x.back();
    };
    const Vec3 coarse = swing(10), fine = swing(40);
    const double size = (fine - start.x.back()).norm();
    EXPECT_GT(size, 0.02);
    EXPECT_LT((coarse - fine).norm(), 0.05 * size);
}

TEST(Lattice, ACantileverSagsAsBeamTheorySays)
{
    // 0.8 m, 0.1 m square, of 2 cubes across, a tip load that bends it by 0.04 of its length:
    // d = P L^3 / (3 E I) + P L / (kappa G A), the second 1.2 % of the first. Regions of half width
    // 1 and 2 are a quarter and a half of the bar's length: some per cent stiffer or softer.
    const double length = 0.8, edge = 0.1, young = 1e6, nu = 0.3, load = 0.5;
    const double inertia = std::pow(edge, 4) / 12;
    const double expected = load * std::pow(length, 3) / (3 * young * inertia) * 1.012;
    const double omega = std::pow(1.875104 / length, 2) * std::sqrt(young * inertia / 10.0);
    Cubes cubes = box(16, 2, 2, edge / 2, {1000, young, nu});
    std::fill(cubes.mass_damping.begin(), cubes.mass_damping.end(), 2 * omega);  // critical
    for (const int w : {1, 2}) {
        const LatticeBody body = lattice_of(cubes, w);
        State state = rest_state(body);
        Loads loads;
        for (const auto k : first_layer(cubes)) {
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(state.x[k]);
        }
        Force tip;
        tip.kind = Force::Kind::point;
        tip.force = Vec3(0, -load, 0);
        tip.position = Vec3(length, edge / 2, edge / 2);
        tip.radius = 0.75 * edge;
        loads.forces.push_back(tip);
        const double start = state.x.back()[1];
        LatticeOptions options{.half_width = w, .substeps = 60};
        for (double time = 0; time < 14 / omega; time += 1.0 / 24) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
            ASSERT_TRUE(state.report.converged);
        }
        EXPECT_NEAR((start - state.x.back()[1]) / expected, 1, 0.1) << w;
    }
}

TEST(Lattice, DampingEndsVibrationButNotRigidMotion)
{
    const LatticeBody body = lattice_of(crooked(), 2);
    State state = rest_state(body);
    for (auto& x : state.x) x[1] *= 1.2;
    for (auto& v : state.v) v = Vec3(1, 0, 0);
    LatticeOptions options{
        .stiffness = Stiffness::rate, .rate = 60, .damping = 0.02, .substeps = 4};
    for (int frame = 0; frame < 96; ++frame) state = advance(body, state, {}, 1.0 / 24, options);
    EXPECT_LT(misfit(rest_state(body), state), 1e-3);
    EXPECT_NEAR(momenta(body, state).linear.x(), momenta(body, state).size, 1e-2);
}

TEST(Lattice, DampingStartsWithTheSecondStep)
{
    // It takes d of the step before: the first step of a motion has none, and is as without.
    const LatticeBody body = lattice_of(crooked(), 2);
    State state = rest_state(body);
    for (auto& x : state.x) x[1] *= 1.2;
    const auto run = [&](double damping, int steps) {
        State s = state;
        LatticeOptions options{
            .stiffness = Stiffness::rate, .rate = 60, .damping = damping, .substeps = 1};
        for (int i = 0; i < steps; ++i) s = advance(body, std::move(s), {}, 0.01, options);
        return s;
    };
    EXPECT_EQ(run(1, 1).v, run(0, 1).v);
    EXPECT_NE(run(1, 2).v, run(0, 2).v);
}

TEST(Lattice, IsDampedByTheMeanOfItsCubes)
{
    // Two cubes of 1e5 Pa damped by 10 ms and one of 9e5 Pa by 2 ms: the mean by stiffness.
    Cubes cubes = box(3, 1, 1, 0.1);
    cubes.young = {1e5, 1e5, 9e5};
    cubes.stiffness_damping = {0.01, 0.01, 0.002};
    EXPECT_NEAR(lattice_of(cubes, 1).damping, (0.2 * 0.01 + 0.9 * 0.002) / 1.1, 1e-15);
}

TEST(Lattice, FallsUnderTheSumOfAllForces)
{
    const LatticeBody body = lattice_of(crooked(), 2);
    Loads loads;
    Force gravity;
    for (const Vec3& a : {Vec3(0, -9, 0), Vec3(2, 1, 0), Vec3(0, 0, 4)}) {
        gravity.acceleration = a;
        loads.forces.push_back(gravity);
    }
    const State state = advance(body, rest_state(body), loads, 0.5, LatticeOptions{});
    for (const Vec3& v : state.v) EXPECT_LT((v - Vec3(1, -4, 2)).norm(), 1e-4);
}

TEST(Lattice, FallsFarFromTheOriginAsNearIt)
{
    // Single precision measures from the middle of the particles, whatever their number: 10 km away
    // it would know places to a millimetre, and the body would shake by that. Left is what double
    // precision knows them to.
    Loads loads;
    loads.forces.push_back({});
    for (const int cubes : {1, 2, 4}) {
        const LatticeBody body = lattice_of(box(cubes, 1, 1, 0.1), 1);
        State state = rest_state(body);
        for (Vec3& x : state.x) x += Vec3(1e4, 1e4, 1e4);
        for (int f = 0; f < 10; ++f) state = advance(body, state, loads, 1.0 / 24, stiffest(4));
        EXPECT_LT(misfit(rest_state(body), state), 1e-7) << cubes;
    }
}

TEST(Lattice, ABlockRestsOnTheGround)
{
    // Dropped from 0.2 m onto a plane at y = 0 with friction: comes to rest there, not below.
    const Cubes cubes = box(3, 3, 3, 0.1, {1000, 1e5, 0.3});
    const LatticeBody body = lattice_of(cubes, 1);
    State state = rest_state(body);
    for (auto& x : state.x) x[1] += 0.2;
    for (auto& v : state.v) v[0] = 0.5;
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    LatticeOptions options{.damping = 0.03, .substeps = 20};
    for (int frame = 0; frame < 96; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, options);
        for (const Vec3& x : state.x) ASSERT_GT(x[1], -2e-3);
    }
    double lowest = 1, fastest = 0;
    for (const Vec3& x : state.x) lowest = std::min(lowest, x[1]);
    for (const Vec3& v : state.v) fastest = std::max(fastest, v.norm());
    EXPECT_NEAR(lowest, 0, 1e-3);
    EXPECT_LT(fastest, 0.02);
}

TEST(Lattice, PinsReachTheirTargets)
{
    const Cubes cubes = box(4, 1, 1, 0.1);
    const LatticeBody body = lattice_of(cubes, 1);
    State state = rest_state(body);
    Loads loads;
    for (const auto k : first_layer(cubes)) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(state.x[k] + Vec3(0, 0.05, 0));
    }
    state = advance(body, state, loads, 0.1, stiffest(3));
    for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
        EXPECT_EQ(state.x[loads.pins.corner[p]], loads.pins.target[p]);
        EXPECT_NEAR(state.v[loads.pins.corner[p]].y(), 0.5, 1e-12);
    }
}

TEST(Lattice, PinsMoveEvenlyWithinAFrame)
{
    // A frame of two steps is two frames of one, halfway each.
    const Cubes cubes = box(4, 1, 1, 0.1);
    const LatticeBody body = lattice_of(cubes, 1);
    const State rest = rest_state(body);
    const auto led = [&](State state, double share, double dt, int substeps) {
        Loads loads;
        for (const auto k : first_layer(cubes)) {
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(rest.x[k] + share * Vec3(0, 0.125, 0));
        }
        return advance(body, std::move(state), loads, dt, stiffest(substeps, Precision::full));
    };
    const State one = led(rest, 1, 0.5, 2), two = led(led(rest, 0.5, 0.25, 1), 1, 0.25, 1);
    for (std::size_t k = 0; k < one.x.size(); ++k) {
        EXPECT_LT((one.x[k] - two.x[k]).norm(), 1e-12);  // measured from other middles
    }
}

// Swung about a place beside it by 30 degrees a frame: along the arc, not along its chord.
TEST(Lattice, WhatIsSwungAndLetGoFliesOffAlongTheTangent)
{
    const Cubes cubes = box(2, 2, 2, 0.1);
    const LatticeBody body = lattice_of(cubes, 1);
    const Vec3 pivot(-1, 0.1, 0.1);
    constexpr double turn = std::numbers::pi / 6, dt = 1.0 / 24;
    std::vector<std::uint32_t> all;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) all.push_back(k);
    const auto motion = [&](int frames) -> geometry::Transform {
        return Eigen::Translation3d(pivot) * Eigen::AngleAxisd(frames * turn, Vec3::UnitZ()) *
               Eigen::Translation3d(-pivot);
    };
    for (const int substeps : {1, 4}) {
        State state = rest_state(body);
        Loads loads;
        for (int frame = 1; frame <= 4; ++frame) {
            loads.pins = pins_at(cubes, all, motion(frame), pivot);
            state = advance(body, std::move(state), loads, dt, stiffest(substeps, Precision::full));
        }
        loads.pins = {};
        state = advance(body, std::move(state), loads, dt, stiffest(substeps, Precision::full));
        const Vec3 speed = turn / dt * Vec3::UnitZ().cross(motion(4) * Vec3(0.1, 0.1, 0.1) - pivot);
        Vec3 mean = Vec3::Zero();
        for (const Vec3& v : state.v) mean += v / double(state.v.size());
        EXPECT_LT((mean - speed).norm(), 0.01 * speed.norm()) << substeps << mean.transpose();
    }
}

TEST(Lattice, ThreadsGiveTheSameBytes)
{
    const Cubes cubes = box(14, 13, 12, 0.05);
    const LatticeBody body = lattice_of(cubes, 3);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    const auto run = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        State state = rest_state(body);
        for (auto& x : state.x) x[1] = 1.1 * x[1] + 0.001 * x[0];
        for (int frame = 0; frame < 3; ++frame) {
            state = advance(body, state, loads, 1.0 / 24, LatticeOptions{.substeps = 2});
        }
        return state;
    };
    const State one = run(1);
    for (const std::size_t threads : {2u, 8u}) {
        const State many = run(threads);
        EXPECT_EQ(one.x, many.x);
        EXPECT_EQ(one.v, many.v);
        EXPECT_EQ(one.rotation, many.rotation);
    }
}

TEST(Lattice, EveryProcessorGivesTheSameBytes)
{
    const Cubes cubes = box(9, 8, 7, 0.05);
    for (const int w : {1, 2, 3, 5}) {
        for (const bool falls : {true, false}) {
            for (const Precision precision : {Precision::single, Precision::full}) {
                const LatticeBody body = lattice_of(cubes, w);
                Loads loads;
                loads.forces.push_back({});
                if (!falls) loads.colliders.push_back({});
                const auto run = [&] {
                    State state = rest_state(body);
                    for (auto& x : state.x) x[1] = 1.1 * x[1] + 0.001 * x[0] - (falls ? 0 : 0.1);
                    LatticeOptions options{
                        .half_width = w, .damping = 0.5, .substeps = 3, .precision = precision};
                    state = advance(body, state, loads, 1.0 / 24, options);
                    return advance(body, state, loads, 1.0 / 24, options);
                };
                const State first = run();
                on_every_target([&](const char* target) {
                    const State again = run();
                    EXPECT_EQ(again.x, first.x) << target << ", w = " << w;
                    EXPECT_EQ(again.v, first.v) << target << ", w = " << w;
                });
            }
        }
    }
}

TEST(Lattice, WarnsWhenItIsSofterThanItsMaterial)
{
    const LatticeBody body = lattice_of(box(3, 3, 3, 0.01, {1000, 1e9, 0.3}), 1);
    const State state =
        advance(body, rest_state(body), {}, 1.0 / 24, LatticeOptions{.substeps = 2});
    ASSERT_EQ(state.report.warnings.size(), 1u);
    EXPECT_NE(state.report.warnings[0].find("softer than its material"), std::string::npos);
}

// 26 of the 27 cubes of a block lie outside.
TEST(Lattice, WarnsOfInvertedCubesAsBricksDo)
{
    const Cubes cubes = box(3, 3, 3, 0.1, {1000, 1e3, 0.3});
    const LatticeBody lattice = lattice_of(cubes, 1);
    const BricksBody bricks = make_bricks(cubes);
    using Deform = std::function<Vec3(const Vec3&)>;
    const auto warned = [&](const auto& body, const Deform& deform) {
        State state = rest_state(body);
        for (Vec3& x : state.x) x = deform(x);
        std::string all;
        for (const auto& text : advance(body, state, {}, 1e-4, StepOptions{}).report.warnings) {
            if (text.find("inverted or pressed flat") != std::string::npos) all += text;
        }
        return all;
    };
    const auto same = [](const Vec3& x) { return x; };
    const auto mirrored = [](const Vec3& x) { return Vec3(-x.x(), x.y(), x.z()); };
    const auto flat = [](const Vec3& x) { return Vec3(0.05 * x.x(), x.y(), x.z()); };
    const auto thin = [](const Vec3& x) { return Vec3(0.5 * x.x(), x.y(), x.z()); };
    // Of a corner cube's corners, the one outside pushed through the cube.
    const auto dented = [](const Vec3& x) {
        return Vec3(x.norm() < 0.01 ? Vec3(0.5, 0.5, 0.5) : x);
    };
    const std::string all =
        "A quarter of the cubes or more are inverted or pressed flat. Use a stiffer material or "
        "shorter steps: raise step.substeps.";
    const std::string of_bricks =
        all.substr(0, all.size() - 1) + "; where it is 0, lower step.error.";
    for (const Deform& still : {Deform(same), Deform(thin)}) {
        EXPECT_EQ(warned(lattice, still), "");
        EXPECT_EQ(warned(bricks, still), "");
    }
    EXPECT_EQ(warned(lattice, mirrored), all);
    EXPECT_EQ(warned(bricks, mirrored), of_bricks);
    EXPECT_EQ(warned(lattice, flat), "") << "it comes back";
    EXPECT_EQ(warned(bricks, flat), of_bricks);
    EXPECT_EQ(warned(lattice, dented), "") << "one of 26";
    EXPECT_EQ(warned(bricks, dented).rfind("Some cubes are", 0), 0u) << warned(bricks, dented);
}

TEST(Lattice, WarnsOfRegionsTooWideForASlenderBody)
{
    const auto warned = [](const Cubes& cubes, int half_width, Stiffness stiffness) {
        const LatticeOptions options{
            .half_width = half_width, .stiffness = stiffness, .substeps = 1000};
        const LatticeBody body = make_lattice(cubes, options);
        std::string all;
        const State after = advance(body, rest_state(body), {}, 1e-3, options);
        for (const auto& text : after.report.warnings) all += text + "\n";
        return all;
    };
    const Cubes rod = box(10, 3, 3, 0.1), block = box(8, 8, 8, 0.1);
    const Cubes sheet =
        geometry::plane_cubes(geometry::rectangle_cells(32, 8), {1, 0.1, {0, 0, 0}}, 0.02);
    const auto says = [](int w, int length, int take) {
        return fmt::format(
            "A half width of {} is too large for a body {} cubes long: it bends further "
            "than its material. Use a half width of {}, or smaller cubes.\n",
            w, length, take);
    };
    EXPECT_EQ(warned(rod, 4, Stiffness::material), says(4, 10, 1));
    EXPECT_EQ(warned(rod, 1, Stiffness::material), "");
    EXPECT_EQ(warned(rod, 4, Stiffness::rate), "");
    EXPECT_EQ(warned(block, 4, Stiffness::material),
              "A half width of 4 is too large for a body 8 cubes long: it shears less than its "
              "material. Use a half width of 2, or smaller cubes.\n");
    EXPECT_EQ(warned(block, 2, Stiffness::material), "");
    EXPECT_EQ(warned(sheet, 3, Stiffness::material), says(3, 32, 2));
    EXPECT_EQ(warned(sheet, 2, Stiffness::material), "");
}

TEST(Lattice, TellsHowMuchTooFarAThinBodyStretches)
{
    // A bar of one cube's thickness hangs from one end: rho g L^2 / (2 E) of its material.
    const double young = 1e5, density = 1000, g = 9.81, length = 1;
    for (const auto& [half_width, nu] : {std::pair{1, 0.0}, {2, 0.0}, {1, 0.45}, {2, 0.45}}) {
        const Cubes bar = box(
            10, 1, 1, 0.1, {.density = density, .young = young, .poisson = nu, .mass_damping = 6});
        const LatticeOptions options{
            .half_width = half_width, .calibrate = Calibration::bending, .substeps = 600};
        const LatticeBody body = make_lattice(bar, options);
        Loads loads;
        loads.forces.push_back({.kind = Force::Kind::gravity, .acceleration = {g, 0, 0}});
        loads.pins.corner = first_layer(bar);
        for (const auto k : loads.pins.corner) {
            loads.pins.target.push_back(bar.corner_position(k));
        }
        const State end = advance(body, rest_state(body), loads, 3, options);
        double tip = 0;
        for (std::size_t k = 0; k < bar.corner_count(); ++k) {
            tip = std::max(tip, end.x[k].x() - bar.corner_position(k).x());
        }
        const double too_far = tip / (density * g * length * length / (2 * young));
        EXPECT_GT(too_far, 2);
        EXPECT_NEAR(body.soft_stretch, too_far, (nu > 0 ? 0.2 : 0.1) * too_far) << nu;
        ASSERT_FALSE(end.report.warnings.empty());
        EXPECT_NE(end.report.warnings.back().find("stretches about"), std::string::npos);
    }
    const LatticeBody thick = make_lattice(box(10, 4, 4, 0.1), {.half_width = 1});
    EXPECT_LT(thick.soft_stretch, 1.3);
}

TEST(Lattice, TellsHowMuchDampingStepsCanBear)
{
    // A bar of 1 m, held at one end, is let go in its first mode of stretch: f = sqrt(E / rho) / 4
    // L = 2.5 Hz. After a period its tip is at exp(-2 pi^2 f tau) of where it was, by the tau that
    // is told, where 1 s was asked for.
    const Cubes bar = box(10, 2, 2, 0.1, {.density = 1000, .young = 1e5, .poisson = 0});
    const auto mode = [](double x) { return 0.01 * std::sin(std::numbers::pi / 2 * x); };
    const auto run = [&](double damping, int substeps) {
        const LatticeOptions options{.half_width = 1, .damping = damping, .substeps = substeps};
        const LatticeBody body = make_lattice(bar, options);
        Loads loads;
        loads.pins.corner = first_layer(bar);
        for (const auto k : loads.pins.corner) loads.pins.target.push_back(bar.corner_position(k));
        State state = rest_state(body);
        for (Vec3& x : state.x) x[0] += mode(x[0]);
        return advance(body, std::move(state), loads, 0.4, options);
    };
    const State end = run(1, 64);
    ASSERT_EQ(end.report.warnings.size(), 1u);
    const std::string& told = end.report.warnings[0];
    const std::string first = "Damping proportional to stiffness acts as ";
    ASSERT_EQ(told.rfind(first, 0), 0u) << told;
    EXPECT_NE(told.find(" s, not 1 s: "), std::string::npos) << told;
    const double tau = std::stod(told.substr(first.size()));
    double tip = 0;
    for (std::size_t k = 0; k < bar.corner_count(); ++k) {
        tip = std::max(tip, end.x[k][0] - 1);
    }
    const double left = std::exp(-2 * std::numbers::pi * std::numbers::pi * 2.5 * tau);
    EXPECT_NEAR(tip / mode(1), left, 0.1 * left);
    // As many substeps as are advised are enough.
    const std::string fewer = run(0.05, 64).report.warnings.at(0);
    const int advised = std::stoi(fewer.substr(fewer.find("at least ") + 9));
    EXPECT_GT(advised, 64);
    EXPECT_TRUE(run(0.05, advised).report.warnings.empty());
    EXPECT_TRUE(run(0.005, 64).report.warnings.empty());
}

TEST(Lattice, RejectsBadInput)
{
    const LatticeBody body = lattice_of(box(2, 1, 1, 0.1), 1);
    const State rest = rest_state(body);
    State short_one = rest, broken = rest;
    short_one.x.pop_back();
    broken.v[0][0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(advance(body, short_one, {}, 0.1, LatticeOptions{}), std::invalid_argument);
    EXPECT_THROW(advance(body, broken, {}, 0.1, LatticeOptions{}), std::invalid_argument);
    EXPECT_THROW(advance(body, rest, {}, 0, LatticeOptions{}), std::invalid_argument);
    EXPECT_THROW(advance(body, rest, {}, 0.1, LatticeOptions{.substeps = 0}),
                 std::invalid_argument);
    EXPECT_THROW(lattice_of({}, 1), std::invalid_argument);
}
