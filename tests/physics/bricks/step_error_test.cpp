// Steps that are chosen by their error: StepOptions::substeps = 0.

#include "physics/bricks/step_error.hpp"

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/first_motion.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

using geometry::Cubes;

constexpr double whole_frame = 1.0 / 24;

// Two cubes on a rail along x that drag slows: v' = -c v. A step takes v to v / (1 + c dt), and is
// off by c dt^2 v / (1 + c dt) / 2.
TEST(StepsByError, AreAsLongAsDragAllows)
{
    const double c = 60, v = 2, h = 0.05;
    const Cubes cubes = fixtures::box(2, 1, 1, h, {.mass_damping = c});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
        loads.pins.axes.push_back(6);  // y, z
    }
    struct Case {
        double error;
        int steps, tried;
    };
    // Cubes: 0.60 of one step a frame, and 0.23 and 0.08 of the first of 2 and 4.
    for (const auto& [error, steps, tried] : {Case{0.7, 1, 1}, Case{0.3, 2, 3}, Case{0.1, 4, 6}}) {
        State state = rest_state(body);
        add_first_motion(state, cubes, {v, 0, 0}, {0, 0, 0});
        state =
            advance(body, std::move(state), loads, whole_frame, {.substeps = 0, .error = error});
        EXPECT_EQ(state.report.steps, tried) << error;
        double way = 0, speed = v;
        for (int i = 0; i < steps; ++i) {
            speed /= 1 + c * whole_frame / steps;
            way += speed * whole_frame / steps;
        }
        EXPECT_NEAR(state.x[0].x(), way, 1e-8) << error;
        EXPECT_NEAR(state.v[0].x(), speed, 1e-7) << error;
        // Where it hardly moves any more, one step a frame is enough again.
        for (int frame = 0; frame < 4; ++frame) {
            state = advance(body, std::move(state), loads, whole_frame,
                            {.substeps = 0, .error = error, .sleep = false});
        }
        EXPECT_EQ(state.report.steps, 1) << error;
    }
    // Sixteenths of the frame at first, after four that were too long, and longer ones as it slows.
    State state = rest_state(body);
    add_first_motion(state, cubes, {v, 0, 0}, {0, 0, 0});
    state = advance(body, std::move(state), loads, whole_frame, {.substeps = 0, .error = 0.02});
    EXPECT_GT(state.report.steps, 4 + 4);
    EXPECT_LT(state.report.steps, 4 + 16);
}

// What falls along the rail is exact in one step (free_fall.hpp).
TEST(StepsByError, HaveNoneOfWhatFalls)
{
    const Cubes cubes = fixtures::box(2, 1, 1, 0.05);
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
        loads.pins.axes.push_back(5);  // x, z
    }
    const State state =
        advance(body, rest_state(body), loads, whole_frame, {.substeps = 0, .error = 1e-4});
    EXPECT_EQ(state.report.steps, 1);
    EXPECT_NEAR(state.x[0].y(), -0.5 * 9.81 * whole_frame * whole_frame, 1e-6);
}

// What nothing holds moves as a rigid body without an error, however fast it turns.
TEST(StepsByError, FreeBodiesTakeOneAFrame)
{
    for (const bool rigid : {true, false}) {
        const Cubes cubes = fixtures::box(4, 2, 1, 0.1, {.young = 1e8});
        const std::vector<BodyModel> models{{&cubes}};
        BrickOptions options;
        if (rigid) options.rigid = {1};
        const BricksBody body = make_bricks(BodyModels(models), options);
        State state = rest_state(body);
        add_first_motion(state, cubes, {3, 4, 0}, {4, 2, 1});
        Loads loads;
        loads.forces.push_back({});
        for (int frame = 0; frame < 6; ++frame) {
            state = advance(body, std::move(state), loads, whole_frame, {.substeps = 0});
            EXPECT_EQ(state.report.steps, 1) << rigid << ' ' << frame;
        }
    }
}

// A soft bar that is held at one end swings down.
TEST(StepsByError, FollowABarThatSwings)
{
    const Cubes cubes = fixtures::box(8, 1, 1, 0.1, {.young = 2e5});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.pins.corner = fixtures::first_layer(cubes);
    for (const auto k : loads.pins.corner) {
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    const auto way_of_the_end = [&](const StepOptions& options) {
        std::vector<Vec3> out;
        State state = rest_state(body);
        for (int frame = 0; frame < 16; ++frame) {
            state = advance(body, std::move(state), loads, whole_frame, options);
            out.push_back(state.x.back());
        }
        return out;
    };
    const auto truth = way_of_the_end({.substeps = 64});
    const auto error = [&](const StepOptions& options) {
        const auto way = way_of_the_end(options);
        double most = 0;
        for (std::size_t i = 0; i < way.size(); ++i) {
            most = std::max(most, (way[i] - truth[i]).norm());
        }
        return most;
    };
    const double one = error({}), tenth = error({.substeps = 0, .error = 0.1}),
                 less = error({.substeps = 0, .error = 0.01});
    EXPECT_GT(one, 0.07);
    EXPECT_LT(tenth, 0.055);
    EXPECT_LT(less, 0.017);
}

TEST(StepsByError, AreOfImplicitEulerAlone)
{
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1);
    const BricksBody body = make_bricks(cubes);
    for (const Integrator integrator : {Integrator::implicit_midpoint, Integrator::sdirk2}) {
        const auto after = [&](int substeps) {
            State state = rest_state(body);
            state.v[0].x() = 0.5;
            return advance(body, std::move(state), {}, 0.1,
                           {.integrator = integrator, .substeps = substeps});
        };
        const State chosen = after(0), one = after(1);
        EXPECT_EQ(chosen.x, one.x);
        EXPECT_EQ(chosen.report.steps, one.report.steps);
    }
}

}  // namespace
}  // namespace physics
