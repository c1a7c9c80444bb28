// Radial forces keep the energy of what moves in them. Near the position of one of radius R, its
// acceleration is -omega^2 x, but for a share of 2 (|x| / R)^2.

#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/state/first_motion.hpp"
#include "physics/state/part_joint.hpp"
#include "physics/state/state_models.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Cubes;

constexpr double a_frame = 1.0 / 24, omega = 12;  // rad/s: half a radian in a frame

// Towards the origin, or away from it.
Loads drawn(double sign = -1)
{
    Loads out;
    out.forces.push_back({.kind = Force::Kind::radial,
                          .position = Vec3::Zero(),
                          .radius = 1e4,
                          .outward = sign * omega * omega * 1e3});
    return out;
}

Cubes bar_at(const Vec3& centre, int length = 2)
{
    Cubes out = fixtures::box(length, 2, 2, 0.05, {.young = 1e7});
    out.origin = centre - 0.025 * Vec3(length, 2, 2);
    return out;
}

Vec3 centre_of(const State& state)
{
    Vec3 sum = Vec3::Zero();
    for (const Vec3& x : state.x) sum += x;  // bars are even: so is the mean of their corners
    return sum / double(state.x.size());
}

// Drift, kick and drift of t seconds take x_n to 2 x_n cos(angle) - x_(n - 1),
// cos(angle) = 1 - (omega t)^2 / 2, so that what is let go at x_0 is at x_0 cos(n angle).
template <class Body> void swings_for_ever(const Body& body, const StepOptions& options)
{
    const int substeps = std::max(1, options.substeps);
    const double t = a_frame / substeps, angle = std::acos(1 - 0.5 * omega * omega * t * t);
    State state = rest_state(body);
    for (int frame = 1; frame <= 120; ++frame) {
        state = advance(body, std::move(state), drawn(), a_frame, options);
        ASSERT_NEAR(centre_of(state).x(), 0.6 * std::cos(substeps * frame * angle), 1e-4)
            << frame << " " << substeps << " " << int(options.integrator);
    }
}

TEST(RadialOnWay, WhatIsDrawnToAPlaceSwingsThroughItForEver)
{
    const Cubes cubes = bar_at({0.6, 0, 0});
    for (const int substeps : {1, 3}) {
        swings_for_ever(make_bricks(cubes), {.substeps = substeps});
        swings_for_ever(make_bricks(cubes, {.rigid = {1}}), {.substeps = substeps});
        swings_for_ever(make_springs(cubes), {.substeps = substeps});
        swings_for_ever(make_bricks(cubes),
                        {.integrator = Integrator::implicit_midpoint, .substeps = substeps});
    }
}

// As with forces that know nothing of places, sdirk2 loses a bit; it gained a third in each swing.
TEST(RadialOnWay, Sdirk2SwingsNoFurther)
{
    const BricksBody body = make_bricks(bar_at({0.6, 0, 0}));
    State state = rest_state(body);
    double most = 0;
    for (int frame = 1; frame <= 120; ++frame) {
        state = advance(body, std::move(state), drawn(), a_frame,
                        {.integrator = Integrator::sdirk2, .substeps = 4});
        if (frame > 96) most = std::max(most, std::abs(centre_of(state).x()));
    }
    EXPECT_LT(most, 0.6);
    EXPECT_GT(most, 0.57);
}

// The force on a body about its centre draws or presses evenly, and turns it by nothing.
TEST(RadialOnWay, WhatSpinsAboutItsPositionGoesOnAsItDoes)
{
    const Cubes cubes = bar_at(Vec3::Zero(), 6);
    for (const bool rigid : {false, true}) {
        const BricksBody body = rigid ? make_bricks(cubes, {.rigid = {1}}) : make_bricks(cubes);
        for (const double sign : {-1, 1}) {
            State state = rest_state(body);
            add_first_motion(state, cubes, Vec3::Zero(), {0, 0, 6});
            const double before = fixtures::brick_motion(cubes, state).angular.z();
            for (int frame = 0; frame < 48; ++frame) {
                state = advance(body, std::move(state), drawn(sign), a_frame, StepOptions{});
            }
            EXPECT_NEAR(fixtures::brick_motion(cubes, state).angular.z() / before, 1, 1e-3)
                << rigid << sign;
        }
    }
}

// On a hinge through its position all places of a bar have the same potential.
TEST(RadialOnWay, WhatWhirlsOnAHingeGoesOnAsItDoes)
{
    const Cubes cubes = bar_at({0.15, 0.05, 0}, 6);  // an edge is x = y = 0
    for (const bool rigid : {false, true}) {
        const BricksBody body = rigid ? make_bricks(cubes, {.rigid = {1}}) : make_bricks(cubes);
        Loads loads = drawn();
        State state = rest_state(body);
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            const Vec3 at = cubes.corner_position(k);
            state.v[k] = Vec3(0, 0, 6).cross(at);
            if (Vec3(at.x(), at.y(), 0).norm() > 1e-9) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(at);
        }
        const double before = fixtures::brick_motion(cubes, state).energy;
        for (int frame = 0; frame < 48; ++frame) {
            state = advance(body, std::move(state), loads, a_frame, StepOptions{});
        }
        EXPECT_NEAR(fixtures::brick_motion(cubes, state).energy / before, 1, rigid ? 1e-3 : 0.05)
            << rigid;
    }
}

TEST(RadialOnWay, WhatSlidesOnAFloorKeepsToItsCircle)
{
    const Cubes puck = bar_at({0.6, 0.05, 0});
    const BricksBody body = make_bricks(puck, {.rigid = {1}});
    Loads loads = drawn();
    loads.forces.push_back({.acceleration = {0, -100, 0}});  // more than lifts its rims
    loads.colliders.emplace_back();
    loads.colliders.back().friction = 0;
    State state = rest_state(body);
    add_first_motion(state, puck, {0, 0, -0.6 * omega}, Vec3::Zero());
    const StepOptions options{.substeps = 4};
    for (int frame = 0; frame < 96; ++frame) {
        state = advance(body, std::move(state), loads, a_frame, options);
        const Vec3 at = centre_of(state);
        ASSERT_NEAR(at.y(), 0.05, 0.005) << frame;
        ASSERT_NEAR(std::hypot(at.x(), at.z()), 0.6, 0.06) << frame;  // starts beside its circle
    }
}

TEST(RadialOnWay, TwoThatAJointLinksKeepToTheirCircle)
{
    const std::vector<std::shared_ptr<const Cubes>> cubes = {
        std::make_shared<const Cubes>(bar_at({0.55, 0, 0})),
        std::make_shared<const Cubes>(bar_at({0.65, 0, 0}))};
    for (const std::uint8_t rigid : {std::uint8_t{0}, std::uint8_t{1}}) {
        const std::vector<StateModel> models = number_models(cubes);
        const std::vector<BodyModel> all = {{cubes[0].get()}, {cubes[1].get()}};
        const BricksBody body =
            make_bricks(BodyModels(all), {.contact = {.on = false}, .rigid = {rigid, rigid}});
        Loads loads = drawn();
        loads.joints = points_of_all(
            make_joint(cubes,
                       {.kind = PartJointKind::hinge, .position = {0.6, 0, 0}, .axis = {0, 0, 1}}),
            cubes, models);
        State state = rest_state(body);
        for (Vec3& v : state.v) v.y() = 0.6 * omega;
        for (int frame = 0; frame < 96; ++frame) {
            state = advance(body, std::move(state), loads, a_frame, {.substeps = 4});
            ASSERT_NEAR(centre_of(state).norm(), 0.6, 0.01) << frame << " " << int(rigid);
        }
    }
}

// The way is dt^2 am / 2, and by Simpson's rule dt^2 (a0 + 2 am) / 6; with a0 = 0 and v it is off
// by dt^3 omega^2 v / 12.
TEST(RadialOnWay, ErrorsOfStepsTellOfIt)
{
    const Cubes cubes = bar_at(Vec3::Zero());
    const BricksBody body = make_bricks(cubes, {.rigid = {1}});
    const double v = 3, dt = a_frame;
    State state = rest_state(body);
    add_first_motion(state, cubes, {v, 0, 0}, Vec3::Zero());
    state = advance(body, std::move(state), drawn(), dt, {.substeps = 1});
    EXPECT_NEAR(state.report.step_error, dt * dt * dt * omega * omega * v / 12 / 0.05, 1e-6);
}

}  // namespace
}  // namespace physics
