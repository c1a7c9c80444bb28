// Balls that touch the faces of cubes, not their points alone.

#include "physics/lattice/ball_faces.hpp"
#include "physics/lattice/lattice_contact.hpp"
#include "tests/physics/lattice/lattice_fixtures.hpp"

#include <gtest/gtest.h>

using namespace physics;
using fixtures::box;
using fixtures::whole_sheet;
using geometry::Cubes;

namespace {

// A body at rest and one ball, about to take a step.
struct BallBeside {
    CornerBody body;
    State state;
    std::vector<double> inverse_mass;
    std::vector<Ball> balls;
    double dt = 0.01;

    BallBeside(const Cubes& cubes, const Ball& ball) : body(make_corner_body(cubes, {}, nullptr))
    {
        state.x = geometry::corner_positions(cubes);
        state.v.assign(state.x.size(), Vec3::Zero());
        for (const double m : body.mass) inverse_mass.push_back(1 / m);
        balls.push_back(ball);
        state.balls = {{.x = ball.position, .v = ball.velocity}};
    }
    ContactScene scene() const { return {body, state, inverse_mass, dt, balls}; }
};

// The least height of the ball's centre in the last of `seconds`, when it falls on a body with some
// pinned corners.
double height_after(double seconds, const Cubes& cubes, const Ball& ball,
                    const std::function<bool(std::size_t)>& is_pinned, int substeps = 0)
{
    LatticeOptions options{.half_width = 1, .damping = 0.005};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    loads.balls.push_back(ball);
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (!is_pinned(k)) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    State state = rest_state(body);
    for (int f = 0; f < int(24 * seconds); ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, StepOptions{.substeps = substeps});
    }
    return state.balls[0].x[1];
}

}  // namespace

TEST(BallFaces, HoldABallOnCubesThatItWouldFitBetween)
{
    // A face of 0.2 m has its corners 0.141 m from its middle.
    const Cubes cubes = box(3, 2, 3, 0.2, {1000, 1e6, 0.3});
    for (const double radius : {0.03, 0.13, 0.21}) {
        for (const Vec3& at : {Vec3(0.3, 0, 0.3), Vec3(0.27, 0, 0.22)}) {
            Ball ball{.radius = radius, .mass = 1, .position = at + Vec3(0, 0.7, 0)};
            const double height = height_after(
                1, cubes, ball, [&](std::size_t k) { return cubes.corner[k][1] == 0; });
            EXPECT_NEAR(height, 0.4 + radius, 0.01) << radius << ' ' << at[0];
        }
    }
}

TEST(BallFaces, HoldABallOfAnySizeOnASheet)
{
    const Cubes cubes = whole_sheet(6, 6);
    const auto at_rim = [&](std::size_t k) {
        return cubes.corner[k][0] % 6 == 0 || cubes.corner[k][2] % 6 == 0;
    };
    for (const double radius : {0.01, 0.03, 0.06}) {
        const Ball ball{.radius = radius, .mass = 0.01, .position = Vec3(0.35, 0.5, 0.25)};
        const double height = height_after(1, cubes, ball, at_rim);
        // The sheet sags by some 50 mm; in a second of free fall the ball comes to -4.4 m.
        EXPECT_GT(height, radius - 0.1) << radius;
        EXPECT_LT(height, radius + 0.1) << radius;
        // In steps of a frame it swings by half a metre, and turns under the ball.
        EXPECT_GT(height_after(1, cubes, ball, at_rim, 1), -0.5) << radius;
    }
}

TEST(BallFaces, ShareAPushByTheWeightsOfThePlace)
{
    // The ball comes down beside the middle of the cube's upper face, which then moves with it, and
    // all momentum stays.
    const double radius = 0.04, gap = 0.01;
    const Ball ball{.radius = radius,
                    .mass = 2,
                    .position = Vec3(0.07, 0.1 + radius + gap, 0.02),
                    .velocity = Vec3(0, -3, 0),
                    .friction = 0.5};
    BallBeside given(box(1, 1, 1, 0.1), ball);
    const ContactScene scene = given.scene();
    const auto touches = find_face_touches(scene, 0);
    ASSERT_EQ(touches.size(), 1u);
    Vec3 place = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        place += touches[0].weight[a] * given.state.x[touches[0].corners[a]];
    }
    EXPECT_LT((place - Vec3(0.07, 0.1, 0.02)).norm(), 1e-6);  // faces are in single precision
    EXPECT_LT((touches[0].normal - Vec3::UnitY()).norm(), 1e-6);
    EXPECT_NEAR(touches[0].gap, gap - 3 * given.dt, 1e-6);

    Pushes pushes;
    pushes.balls = find_ball_pushes(scene, {});
    ASSERT_EQ(pushes.balls.size(), 1u);
    std::vector<Vec3> v = given.state.v;
    std::vector<BallState> balls = given.state.balls;
    solve_pushes(scene, pushes, 1, v, balls);
    const Vec3 before = ball.mass * ball.velocity;
    Vec3 after = ball.mass * balls[0].v, of_place = Vec3::Zero();
    for (std::size_t k = 0; k < v.size(); ++k) after += given.body.mass[k] * v[k];
    for (std::size_t a = 0; a < 8; ++a) {
        of_place += touches[0].weight[a] * v[touches[0].corners[a]];
    }
    EXPECT_LT((after - before).norm(), 1e-9);
    EXPECT_NEAR((balls[0].v - of_place)[1], -gap / given.dt, 1e-3);  // the gap closes
}

TEST(BallFaces, StopWhatPassesThroughThemInAStep)
{
    // From either side of a sheet, many times its radius in a step.
    for (const double side : {1.0, -1.0}) {
        const Ball ball{.radius = 0.01,
                        .mass = 1,
                        .position = Vec3(0.13, 0.05 * side, 0.26),
                        .velocity = Vec3(0, -40 * side, 0)};
        BallBeside given(whole_sheet(4, 4), ball);
        const auto touches = find_face_touches(given.scene(), 0);
        ASSERT_EQ(touches.size(), 1u);
        EXPECT_LT((touches[0].normal - side * Vec3::UnitY()).norm(), 1e-6);
        Pushes pushes;
        pushes.balls = find_ball_pushes(given.scene(), {});
        std::vector<BallState> balls = given.state.balls;
        solve_pushes(given.scene(), pushes, 1, given.state.v, balls);
        double sheet = 0;  // speed of the place that is touched
        for (std::size_t a = 0; a < 8; ++a) {
            sheet += touches[0].weight[a] * given.state.v[touches[0].corners[a]][1];
        }
        // Half of the sheet's 20 mm, and the ball's radius.
        const double apart = side * (0.05 * side + given.dt * (balls[0].v[1] - sheet));
        EXPECT_NEAR(apart, 0.02, 1e-6);
    }
}

TEST(BallFaces, PushOnceWhereNeighboursLieInOnePlane)
{
    // A ball deep in a face, beside the next cube: only the face below it pushes. In a corner
    // between a step's face and its side both do.
    const Ball deep{.radius = 0.09, .mass = 1, .position = Vec3(0.18, 0.17, 0.15)};
    const BallBeside flat(box(4, 1, 3, 0.1), deep);
    const auto one = find_face_touches(flat.scene(), 0);
    ASSERT_EQ(one.size(), 1u);
    EXPECT_LT((one[0].normal - Vec3::UnitY()).norm(), 1e-6);

    std::vector<geometry::Vec3i> cells;
    for (int x = 0; x < 4; ++x) cells.emplace_back(x, 0, 0);
    cells.emplace_back(3, 1, 0);
    const Ball between{.radius = 0.05, .mass = 1, .position = Vec3(0.251, 0.149, 0.05)};
    const BallBeside stair(fixtures::cubes_on(cells, 0.1), between);
    const auto two = find_face_touches(stair.scene(), 0);
    ASSERT_EQ(two.size(), 2u);
    EXPECT_LT((two[0].normal + two[1].normal - Vec3(-1, 1, 0)).norm(), 1e-6);
}
