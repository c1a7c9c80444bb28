// Stiff bodies of few cubes stand for rigid ones, one step of implicit Euler a frame.

#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/hinged_bar.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

constexpr fixtures::Stuff stiff{.density = 1000, .young = 1e9};

TEST(StiffBodies, SwingOnAHingeWithThePeriodOfAPendulum)
{
    const fixtures::HingedBar bar(stiff);
    ASSERT_EQ(bar.loads.pins.corner.size(), 2u);
    const BricksBody body = make_bricks(bar.cubes);
    State state = rest_state(body);
    const double start = state.x[0].x();
    const auto turns = bar.turns(body, state, 1.0 / 24, 70);
    ASSERT_EQ(turns.size(), 4u);  // two periods are 2.56 s
    EXPECT_NEAR(turns[3] / 2, bar.period, 0.003 * bar.period);
    EXPECT_NEAR(fixtures::shape_error(bar.cubes, state), 0, 1e-3);
    EXPECT_NEAR(state.x[0].x(), start, 0.02);  // it has lost nothing
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
