// Rigid bodies that pins and joints hold, and that swing: where they are at what time.

#include "physics/bricks/bricks.hpp"
#include "physics/state/part_joint.hpp"
#include "physics/state/state_models.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace physics {
namespace {

using geometry::Cubes;

constexpr double frame_seconds = 1.0 / 24, gravity = 9.81, degree = std::numbers::pi / 180;

// Rigid bars of 0.1 x 0.1 m, in a row along x.
struct Swing {
    std::vector<std::shared_ptr<const Cubes>> cubes;
    std::vector<StateModel> models;
    BricksBody body;
    Loads loads;
    State state;
    StepOptions options;

    // `lengths` in cubes of 0.1 m
    Swing(const std::vector<int>& lengths, int substeps)
    {
        double x = 0;
        for (const int length : lengths) {
            Cubes bar = fixtures::box(length, 1, 1, 0.1, {.young = 1e9});
            bar.origin = {x, 0, 0};
            cubes.push_back(std::make_shared<const Cubes>(std::move(bar)));
            x += 0.1 * length + 0.02;
        }
        models = number_models(cubes);
        std::vector<BodyModel> all;
        for (const auto& some : cubes) all.push_back({some.get()});
        body = make_bricks(BodyModels(all), {.contact = {.on = false},
                                             .rigid = std::vector<std::uint8_t>(all.size(), 1)});
        state = rest_state(body);
        loads.forces.push_back({.acceleration = {0, -gravity, 0}});
        options.substeps = substeps;
    }
    template <class Choose> void pin(const Choose& chosen)  // of the first bar
    {
        for (std::uint32_t k = 0; k < cubes[0]->corner_count(); ++k) {
            const Vec3 at = cubes[0]->corner_position(k);
            if (!chosen(at)) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(at);
        }
    }
    void pin_edge()  // x = y = 0
    {
        pin([](const Vec3& at) { return at.x() < 1e-9 && at.y() < 1e-9; });
    }
    void join(std::size_t a, const Vec3& at)  // a hinge along z, with the next one
    {
        const std::vector<std::shared_ptr<const Cubes>> two = {cubes[a], cubes[a + 1]};
        const auto points = points_of_all(
            make_joint(two, {.kind = PartJointKind::hinge, .position = at, .axis = {0, 0, 1}}),
            cubes, models);
        loads.joints.insert(loads.joints.end(), points.begin(), points.end());
    }
    void step() { state = advance(body, std::move(state), loads, frame_seconds, options); }
    State of(std::size_t bar) const
    {
        std::size_t first = 0;
        for (std::size_t i = 0; i < bar; ++i) first += cubes[i]->corner_count();
        const auto begin = static_cast<std::ptrdiff_t>(first);
        const auto end = begin + static_cast<std::ptrdiff_t>(cubes[bar]->corner_count());
        State out;
        out.x.assign(state.x.begin() + begin, state.x.begin() + end);
        out.v.assign(state.v.begin() + begin, state.v.begin() + end);
        return out;
    }
    Vec3 centre(std::size_t bar) const
    {
        const State own = of(bar);
        Vec3 sum = Vec3::Zero();
        for (const Vec3& x : own.x) sum += x;  // bars are even: so is the mean of their corners
        return sum / static_cast<double>(own.x.size());
    }
    double energy() const  // J
    {
        double sum = 0;
        for (std::size_t i = 0; i < cubes.size(); ++i) {
            const auto motion = fixtures::brick_motion(*cubes[i], of(i));
            sum += motion.energy + geometry::total_mass(*cubes[i]) * gravity * centre(i).y();
        }
        return sum;
    }
};

// A bar of 1 m on a hinge, its centre d from it.
struct Pendulum {
    double d, rate, amplitude;  // m, rad/s of small swings, rad

    double period() const { return 4 / rate * std::comp_ellint_1(std::sin(0.5 * amplitude)); }
    // Steps of second order are off by a share of the square of how far a step turns at most, or of
    // tau times the rate: measured are 0.35 of it and less. A step early is 4 tau / T.
    double tolerance(double tau) const
    {
        const double turn = tau * rate * std::max(1.0, 2 * std::sin(0.5 * amplitude));
        return 0.5 * turn * turn + 5e-4;  // lines between frames, and pins that give way
    }
};

Pendulum pendulum_of(double amplitude, const Vec3& arm)
{
    const double d_sq = arm.squaredNorm(), inertia = (1 + 0.01) / 12 + d_sq;  // of each kg
    return {std::sqrt(d_sq), std::sqrt(gravity * std::sqrt(d_sq) / inertia), amplitude};
}

// When it first passes below the hinge, at a fourth of the period, s.
double first_pass(Swing& swing, std::size_t bar, const Vec3& hinge)
{
    const auto angle = [&] {
        const Vec3 arm = swing.centre(bar) - hinge;
        return std::atan2(arm.x(), -arm.y());
    };
    for (int frame = 0; frame < 48; ++frame) {
        const double before = angle();
        swing.step();
        const double after = angle();
        if (after <= 0) return swing.state.time - frame_seconds * after / (after - before);
    }
    return 0;
}

// Implicit Euler's place after a step from rest is a tau^2 ahead in place of a tau^2 / 2, and the
// energy of that place made the velocity sqrt(2) of what it is: the pendulum came a step early, and
// up to two, however many steps a frame has.
TEST(HeldPlaces, AHingedBarThatIsLetGoComesInTime)
{
    for (const double degrees : {30.0, 90.0, 150.0}) {
        for (const int substeps : {1, 2, 4, 8, 32}) {
            Swing swing({10}, substeps);
            swing.pin_edge();
            const Pendulum exact = pendulum_of(degrees * degree, {0.5, 0.05, 0});
            const double turn = degrees * degree - std::numbers::pi / 2 - std::atan2(0.05, 0.5);
            for (Vec3& x : swing.state.x) x = Eigen::AngleAxisd(turn, Vec3::UnitZ()) * x;
            const double t = first_pass(swing, 0, Vec3::Zero()), tau = frame_seconds / substeps;
            EXPECT_NEAR(4 * t / exact.period(), 1, exact.tolerance(tau)) << degrees << ' ' << tau;
        }
    }
}

// The same on the hinge of a joint with a block that is pinned.
TEST(HeldPlaces, ARodOnAJointComesInTime)
{
    for (const int substeps : {1, 4, 16}) {
        Swing swing({1, 10}, substeps);
        swing.pin([](const Vec3&) { return true; });
        const Vec3 hinge(0.11, 0.05, 0.05);
        swing.join(0, hinge);
        const Pendulum exact = pendulum_of(90 * degree, swing.centre(1) - hinge);
        const double t = first_pass(swing, 1, hinge), tau = frame_seconds / substeps;
        EXPECT_NEAR(4 * t / exact.period(), 1, exact.tolerance(tau)) << tau;
    }
}

// While the force is all the same, at the first step from level, it turns by alpha tau^2 / 2.
TEST(HeldPlaces, OneStepFromRestIsThatOfAParabola)
{
    Swing swing({10}, 1);
    swing.pin_edge();
    const double began = std::atan2(0.05, 0.5);
    const double alpha = gravity * 0.5 / ((1 + 0.01) / 12 + 0.25 + 0.0025);
    swing.step();
    const Vec3 centre = swing.centre(0);
    const double turned = began - std::atan2(centre.y(), centre.x());
    EXPECT_NEAR(turned, 0.5 * alpha * frame_seconds * frame_seconds, 0.01 * turned);
}

TEST(HeldPlaces, ChainsThatAreLetGoKeepTheirEnergy)
{
    for (const int links : {2, 6}) {
        Swing chain(std::vector<int>(std::size_t(links), 4), 4);
        chain.pin_edge();
        double scale = 0;  // J, of a fall by its length
        for (int i = 0; i < links; ++i) {
            if (i > 0) chain.join(std::size_t(i - 1), {0.42 * i - 0.01, 0.05, 0.05});
            scale += geometry::total_mass(*chain.cubes[0]) * gravity * (0.42 * i + 0.2);
        }
        const double began = chain.energy();
        for (int frame = 0; frame < 240; ++frame) {
            chain.step();
            ASSERT_NEAR(chain.energy(), began, 1e-4 * scale) << links << ' ' << frame;
        }
    }
}

// A bar that spins and swings on one pinned corner: weight has no moment about the plumb line
// there.
TEST(HeldPlaces, ATopKeepsItsMomentumAboutThePlumbLine)
{
    Swing top({6}, 4);
    top.pin([](const Vec3& at) { return at.norm() < 1e-9; });
    for (std::size_t k = 0; k < top.state.x.size(); ++k) {
        top.state.v[k] = Vec3(4, 3, 0).cross(top.state.x[k]);
    }
    const double began = fixtures::brick_motion(*top.cubes[0], top.state).angular.y();
    for (int frame = 0; frame < 24; ++frame) top.step();
    const double ends = fixtures::brick_motion(*top.cubes[0], top.state).angular.y();
    EXPECT_NEAR(ends, began, 0.05 * began);  // it was 18 % off
}

// A hinge that catches a bar takes all of its momentum but that about the hinge:
// T = L^2 / (2 I). Of that, steps of a 96th lose as much as it turns in one: 3 %.
TEST(HeldPlaces, WhatAHingeCatchesIsHit)
{
    Swing bar({10}, 4);
    bar.pin_edge();
    bar.loads.forces.clear();
    for (Vec3& v : bar.state.v) v = Vec3(1, -2, 0);
    const double mass = geometry::total_mass(*bar.cubes[0]);
    const double momentum = mass * (-2 * 0.5 - 1 * 0.05), inertia = mass * (1 + 0.01) / 3;
    const double caught = momentum * momentum / (2 * inertia);
    for (int frame = 0; frame < 12; ++frame) {
        bar.step();
        const double energy = fixtures::brick_motion(*bar.cubes[0], bar.state).energy;
        ASSERT_LT(energy, 1.001 * caught) << frame;
        ASSERT_GT(energy, 0.94 * caught) << frame;
    }
}

}  // namespace
}  // namespace physics
