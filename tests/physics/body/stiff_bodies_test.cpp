// Stiff bodies of few cubes stand for rigid ones, one step of implicit Euler a frame.

#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace physics {
namespace {

constexpr fixtures::Stuff stiff{.density = 1000, .young = 1e9};

// A bar of 0.1 x 0.6 x 0.1 m hangs on one edge of its upper end, which is a hinge. It swings about
// the way in which its centre is below the hinge, 9.46 degrees from how it starts, with
//   T = 2 pi sqrt(I / (m g d)) (1 + angle^2 / 16),  I / m = (0.1^2 + 0.6^2) / 12 + d^2,
//   d^2 = 0.05^2 + 0.3^2
TEST(StiffBodies, SwingOnAHingeWithThePeriodOfAPendulum)
{
    const geometry::Cubes cubes = fixtures::box(1, 6, 1, 0.1, stiff);
    Loads loads;
    loads.forces.push_back({});
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].y() < 6 || cubes.corner[k].x() > 0) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    ASSERT_EQ(loads.pins.corner.size(), 2u);
    const double d_sq = 0.05 * 0.05 + 0.3 * 0.3, angle = std::atan(0.05 / 0.3);
    const double period = 2 * std::numbers::pi *
                          std::sqrt((0.37 / 12 + d_sq) / (9.81 * std::sqrt(d_sq))) *
                          (1 + angle * angle / 16);
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    const std::size_t low = 0;
    const double start = state.x[low].x();
    std::vector<double> turns;  // s: when it goes back
    constexpr double dt = 1.0 / 24;
    double before = 0;
    for (int frame = 0; frame < 70 && turns.size() < 4; ++frame) {
        state = advance(body, state, loads, dt);
        const double speed = state.v[low].x();
        if (before != 0 && (speed > 0) != (before > 0)) {
            turns.push_back(state.time - dt * speed / (speed - before));
        }
        before = speed;
    }
    ASSERT_EQ(turns.size(), 4u);  // two periods are 2.56 s
    EXPECT_NEAR(turns[3] / 2, period, 0.003 * period);
    EXPECT_NEAR(fixtures::shape_error(cubes, state), 0, 1e-3);
    EXPECT_NEAR(state.x[low].x(), start, 0.02);  // it has lost nothing
}

// Thrown in space, it keeps its momenta and its shape, one step a frame, at two turns a second.
TEST(StiffBodies, TumbleWithoutChange)
{
    const geometry::Cubes cubes = fixtures::box(1, 4, 2, 0.1, stiff);
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    const Vec3 centre(0.05, 0.2, 0.1), spin(3, 4, 11);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        state.v[k] = Vec3(1, 2, 3) + spin.cross(state.x[k] - centre);
    }
    const auto first = fixtures::brick_motion(cubes, state);
    for (int frame = 0; frame < 48; ++frame) state = advance(body, state, {}, 1.0 / 24);
    const auto last = fixtures::brick_motion(cubes, state);
    EXPECT_LT((last.linear - first.linear).norm(), 1e-6 * first.linear.norm());
    EXPECT_LT((last.angular - first.angular).norm(), 1e-6 * first.angular.norm());
    EXPECT_NEAR(last.energy, first.energy, 0.01 * first.energy);
    EXPECT_NEAR(fixtures::shape_error(cubes, state), 0, 1e-3);
}

}  // namespace
}  // namespace physics
