#include "layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics {

using namespace layered_fixtures;

namespace {

LayeredBody rigid_ball(const Vec3& at)
{
    LayeredBody body = ball(at, 2e4, 0.02);
    body.matter.rigid = true;
    return body;
}

// Of half sizes 0.2, 0.15 and 0.2 m with its rounding, its middle at `at`.
LayeredBody rigid_box(const Vec3& at)
{
    Skeleton box{.kind = SkeletonKind::box, .points = {}, .half_size = {0.15, 0.1, 0.15}};
    box.place.translate(at);
    ImplicitLayer layer = soft_layer({box});
    layer.contributions[0] = {.thickness = 0.05, .stiffness = 10, .radius = 0.2};
    LayeredBody body = make_layered_body(layer, BaseKind::rigid, 1000, 0.03);
    body.matter.rigid = true;
    body.matter.friction = 0;
    return body;
}

LayeredScene after(LayeredScene scene, int frames, const LayeredWorld& world = {})
{
    for (int frame = 0; frame < frames; ++frame) {
        scene = advance(scene, scene.parts, world, 1.0 / 24, 2);
    }
    return scene;
}

}  // namespace

// They used to fall through: 20 frames are 3.4 m of free fall.
TEST(RigidTouch, ARigidBallRestsOnARigidFloorAndOnACollider)
{
    std::vector<LayeredPart> parts(2);
    parts[0].body = std::make_shared<const LayeredBody>(rigid_ball({0, 0.3, 0}));
    parts[1].body = std::make_shared<const LayeredBody>(floor_at(0));
    for (const bool collider : {false, true}) {
        if (collider) parts[1] = rigid_part(Collider{});
        const LayeredScene scene = after(start(parts), 20);
        // Its samples carry it: a sphere's polyhedron is as high as its vertices.
        EXPECT_NEAR(scene.states[0].position[0].y(), 0.1, 1e-3);
        EXPECT_LT(fastest(scene), 1e-2);
        EXPECT_LT(interpenetration(scene), 1e-3);
    }
}

// They fall by 1 and by 3 cm until they touch.
TEST(RigidTouch, RigidBoxesStandOnEachOtherAndStayLevel)
{
    const LayeredScene begin =
        scene_of({rigid_box({0, 0.16, 0}), rigid_box({0.03, 0.48, 0.02}), floor_at(0)});
    const LayeredScene scene = after(begin, 24);
    const auto fallen = [&](std::size_t b) {
        return begin.states[b].position[0].y() - scene.states[b].position[0].y();
    };
    EXPECT_NEAR(fallen(0), 0.01, 2e-4);
    EXPECT_NEAR(fallen(1), 0.03, 4e-4);
    for (const int b : {0, 1}) {
        const Eigen::Quaterniond turn(scene.states[static_cast<std::size_t>(b)].rotation[0]);
        EXPECT_GT((turn * Vec3::UnitY()).y(), 1 - 1e-5);
    }
}

// Without gravity a box hits a box that is at rest: neither goes into the other, nor is momentum
// made or lost.
TEST(RigidTouch, ACollisionKeepsMomentum)
{
    std::vector<LayeredPart> parts(2);
    parts[0].body = std::make_shared<const LayeredBody>(rigid_box({-0.3, 0, 0}));
    parts[0].velocity = Vec3(2, 0, 0);
    parts[1].body = std::make_shared<const LayeredBody>(rigid_box({0.15, 0.02, 0.01}));
    const LayeredScene begin = start(parts), end = after(begin, 10, weightless);
    const double scale = momentum(begin).norm();
    EXPECT_LT((momentum(end) - momentum(begin)).norm(), 1e-6 * scale);
    EXPECT_LT((angular_momentum(end) - angular_momentum(begin)).norm(), 1e-3 * scale);
    EXPECT_GT(end.states[1].velocity[0].x(), 0.9);
    EXPECT_GT(end.states[1].position[0].x() - end.states[0].position[0].x(), 0.39);
}

// Viscous: the speed of a box on a floor falls by the same share in each second.
TEST(RigidTouch, ABoxThatSlidesIsSlowedByFriction)
{
    const auto speeds = [](double friction) {
        LayeredBody body = rigid_box({0, 0.15, 0});
        body.matter.friction = friction;
        std::vector<LayeredPart> parts(2);
        parts[0].body = std::make_shared<const LayeredBody>(body);
        parts[0].velocity = Vec3(0.5, 0, 0);
        LayeredBody floor = floor_at(0);
        floor.matter.friction = friction;
        parts[1].body = std::make_shared<const LayeredBody>(floor);
        const LayeredScene some = after(start(parts), 6), more = after(some, 6);
        return std::pair(some.states[0].velocity[0].x(), more.states[0].velocity[0].x());
    };
    EXPECT_NEAR(speeds(0).second, 0.5, 1e-3);
    const auto [some, more] = speeds(1500);
    EXPECT_LT(some, 0.45);
    EXPECT_NEAR(more / some, some / 0.5, 0.05);
}

// In the step in which it would reach the floor its velocity turns, by either solver.
TEST(RigidTouch, ARigidBallBouncesAsItsBounceSays)
{
    for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
        LayeredBody body = rigid_ball({0, 0.3, 0});
        body.matter.bounce = 0.6;
        std::vector<LayeredPart> parts(2);
        parts[0].body = std::make_shared<const LayeredBody>(body);
        parts[0].velocity = Vec3(0, -2, 0);
        parts[1].body = std::make_shared<const LayeredBody>(floor_at(0));
        const LayeredWorld world{.gravity = Vec3::Zero(), .rigid_bodies = solver};
        const LayeredScene scene = after(start(parts), 5, world);
        EXPECT_NEAR(scene.states[0].velocity[0].y(), 1.2, 0.02);
    }
}

// A soft ball on a rigid box on a floor: the box carries it.
TEST(RigidTouch, ARigidBodyCarriesASoftOne)
{
    LayeredBody clay = ball({0, 0.42, 0});
    clay.matter.restitution = 0;
    const LayeredScene begin = scene_of({rigid_box({0, 0.16, 0}), clay, floor_at(0)});
    const LayeredScene scene = after(begin, 30);
    EXPECT_NEAR(begin.states[0].position[0].y() - scene.states[0].position[0].y(), 0.01, 2e-4);
    const double height = scene.states[1].position[0].y() - 0.3;
    EXPECT_NEAR(height, resting_height(*scene.parts[1].body), 2e-3);
}

}  // namespace physics
