// Force fields on layered bodies, against closed forms.

#include "physics/layered_bodies/layered_loads.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace physics::layered_loads_test {
namespace {

using namespace layered_fixtures;

constexpr double step = 1.0 / 240, radius = 0.1;

class LayeredLoads : public testing::TestWithParam<RigidBodies> {
protected:
    static LayeredWorld world(const Force& force)
    {
        LayeredWorld world{.gravity = Vec3::Zero(), .drag = 0, .rigid_bodies = GetParam()};
        world.forces = {force};
        return world;
    }
};

INSTANTIATE_TEST_SUITE_P(Fields, LayeredLoads,
                         testing::Values(RigidBodies::implicit, RigidBodies::bullet),
                         [](const auto& info) {
                             return info.param == RigidBodies::bullet ? "Bullet" : "Implicit";
                         });

LayeredScene run(LayeredScene scene, const LayeredWorld& world, int steps)
{
    for (int i = 0; i < steps; ++i) scene = advance(scene, scene.parts, world, step, 1);
    return scene;
}

}  // namespace

TEST_P(LayeredLoads, GravityIsAnAccelerationOfAll)
{
    Force force;
    force.kind = Force::Kind::gravity;
    force.acceleration = {1, 2, 3};
    const LayeredScene scene =
        run(scene_of({ball({0, 0, 0}), ball({1, 0, 0}), floor_at(-1)}), world(force), 24);
    for (std::size_t b = 0; b < 2; ++b) {
        EXPECT_LT((scene.states[b].velocity[0] - 0.1 * force.acceleration).norm(), 1e-9);
    }
    EXPECT_EQ(scene.states[2].velocity[0], Vec3::Zero());
}

// m v' = k (w - v)^2, k = rho drag pi r^2 / 2:  w - v = w / (1 + k w t / m).
TEST_P(LayeredLoads, WindTakesABallAlong)
{
    Force wind;
    wind.kind = Force::Kind::wind;
    wind.velocity = {0, 0, 30};
    wind.air_density = 50;
    wind.drag = 0.5;
    const LayeredBody body = ball({0.3, 0.2, 0});
    const double k = 0.5 * wind.air_density * wind.drag * std::numbers::pi * radius * radius;
    const LayeredScene scene = run(scene_of({body}), world(wind), 120);
    const double w = 30, t = 120 * step, left = w / (1 + k * w * t / body.base.mass[0]);
    EXPECT_GT(w - left, 5);
    EXPECT_NEAR(scene.states[0].velocity[0].z(), w - left, 0.01 * (w - left));
    EXPECT_LT(scene.states[0].spin[0].norm(), 1e-2);
}

TEST_P(LayeredLoads, APointForceGivesItsMomentumAndItsTorque)
{
    Force force;
    force.kind = Force::Kind::point;
    force.force = {5, 0, 0};
    force.position = {0, radius, 0};
    for (const double reach : {0.0, 0.03}) {
        force.radius = reach;
        const LayeredBody body = ball({0, 0, 0});
        const LayeredScene scene = run(scene_of({body, ball({1, 0, 0})}), world(force), 6);
        const double t = 6 * step;
        EXPECT_NEAR(momentum(scene).x(), 5 * t, 1e-9);
        EXPECT_NEAR(scene.states[1].velocity[0].norm(), 0, 1e-12);
        // Seeds are 0.03 m apart; within the reach they stand a little lower.
        EXPECT_NEAR(scene.states[0].spin[0].z() * body.base.inertia[0](2, 2), -radius * 5 * t,
                    0.06 * radius * 5 * t);
    }
    // Between two balls it is shared.
    force.position = {0, 0.25, 0};
    force.radius = 0.3;
    const LayeredScene scene =
        run(scene_of({ball({-0.2, 0, 0}), ball({0.2, 0, 0})}), world(force), 6);
    EXPECT_NEAR(momentum(scene).x(), 5 * 6 * step, 1e-9);
    EXPECT_NEAR(scene.states[0].velocity[0].x(), scene.states[1].velocity[0].x(),
                0.05 * scene.states[0].velocity[0].x());
}

// The top of the tall one is 0.03 m away, the bottom of the ball 0.12 m.
TEST_P(LayeredLoads, APointForceTakesAStretchedLayerWhereItEnds)
{
    Skeleton tall = point({0, 0, 0});
    tall.stretch(1, 1) = 3;
    Force force;
    force.kind = Force::Kind::point;
    force.force = {5, 0, 0};
    force.position = {0, 0.33, 0};
    force.radius = 0;
    LayeredBody body = make_layered_body(soft_layer({tall}), BaseKind::rigid, 1000, 0.03);
    const LayeredScene scene = run(scene_of({body, ball({0, 0.55, 0})}), world(force), 6);
    EXPECT_NEAR(scene.states[0].velocity[0].x() * body.base.mass[0], 5 * 6 * step, 1e-9);
    EXPECT_NEAR(scene.states[1].velocity[0].norm(), 0, 1e-12);
}

// Within the radius of a surface, inside of a body, and beside all of them.
TEST(LayeredForces, APointForceFarFromAllLayersIsTold)
{
    std::vector<LayeredPart> parts(2);
    parts[0].body = std::make_shared<const LayeredBody>(ball({0, 0, 0}));
    parts[1].body = std::make_shared<const LayeredBody>(floor_at(-1));
    Force force;
    force.kind = Force::Kind::point;
    force.force = {1, 0, 0};
    force.radius = 0.1;
    const auto told = [&](const Vec3& position) {
        force.position = position;
        return far_point_forces(parts, std::vector<Force>{Force{}, force});
    };
    EXPECT_TRUE(told({0.19, 0, 0}).empty());
    EXPECT_TRUE(told({0, 0, 0}).empty());
    ASSERT_EQ(told({50, 0, 0}).size(), 1u);
    EXPECT_NE(told({50, 0, 0})[0].find("Point force 2 of 2 has no layer within its radius"),
              std::string::npos);
    EXPECT_EQ(told({0, -1, 0}).size(), 1u) << "bodies that are told where to be feel no forces";
    force.force.setZero();
    EXPECT_TRUE(told({50, 0, 0}).empty());
}

TEST_P(LayeredLoads, NumbersThatAreNoneAreRefused)
{
    Force force;
    force.acceleration = {std::nan(""), 0, 0};
    const LayeredScene scene = scene_of({ball({0, 0, 0})});
    EXPECT_THROW(advance(scene, scene.parts, world(force), step, 1), std::invalid_argument);
}

// Near its position a swirl S accelerates by 10 S / R x d, as a spin does that grows: all of a limb
// begins to turn at 10 S / R about it.
TEST_P(LayeredLoads, ASwirlTurnsARigidLimbOfAnyShape)
{
    Force swirl;
    swirl.kind = Force::Kind::radial;
    swirl.radius = 1e4;
    swirl.swirl = {0, 0, 600};
    Skeleton segment{.kind = SkeletonKind::segment, .points = {{0.2, 0, 0}, {1, 0.3, 0}}};
    const LayeredBody limb =
        make_layered_body(soft_layer({segment, point({1, 0, 0})}), BaseKind::rigid, 1000, 0.05);
    const LayeredScene scene = run(scene_of({limb}), world(swirl), 1);
    const Vec3 turn(0, 0, 0.6 * step), at = limb.base.frames[0].translation();
    EXPECT_LT((scene.states[0].spin[0] - turn).norm(), 1e-3 * turn.norm());
    EXPECT_LT((scene.states[0].velocity[0] - turn.cross(at)).norm(), 1e-3 * turn.norm());
}

TEST_P(LayeredLoads, ABlastAtTheEndOfALimbThrowsAndTurnsIt)
{
    Force blast;
    blast.kind = Force::Kind::radial;
    blast.outward = 100;
    blast.radius = 0.4;
    blast.position = {0.45, -0.15, 0};
    const Skeleton segment{.kind = SkeletonKind::segment, .points = {{-0.5, 0, 0}, {0.5, 0, 0}}};
    const LayeredScene scene =
        run(scene_of({make_layered_body(soft_layer({segment}), BaseKind::rigid, 1000, 0.05)}),
            world(blast), 4);
    EXPECT_GT(scene.states[0].velocity[0].y(), 4 * step);  // of 100 m/s^2 on a few hundredths of it
    EXPECT_GT(scene.states[0].spin[0].z(), 4 * step);
}

}  // namespace physics::layered_loads_test
