// What nothing holds falls along a parabola, however long the steps.

#include "physics/layered_bodies/layered_fall.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics::layered_fall_test {
namespace {

using namespace layered_fixtures;

constexpr double g = 9.81, dt = 1.0 / 24;

LayeredScene run(LayeredScene scene, int frames, const LayeredWorld& world = {}, int substeps = 2)
{
    for (int i = 0; i < frames; ++i) scene = advance(scene, scene.parts, world, dt, substeps);
    return scene;
}

// m, by which a body that starts at rest falls in so many frames.
double parabola(int frames)
{
    return 0.5 * g * frames * dt * frames * dt;
}

Vec3 middle_of_mass(const LayeredScene& scene)
{
    Vec3 sum = Vec3::Zero();
    double mass = 0;
    const Base& base = scene.parts[0].body->base;
    for (std::size_t f = 0; f < base.mass.size(); ++f) {
        sum += base.mass[f] * scene.states[0].position[f];
        mass += base.mass[f];
    }
    return sum / mass;
}

}  // namespace

TEST(LayeredFall, ABallFallsAlongAParabolaWithEitherSolver)
{
    for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
        for (const int substeps : {1, 2, 5}) {
            const LayeredWorld world{.rigid_bodies = solver};
            LayeredScene scene = scene_of({ball({0, 10, 0}), floor_at(0)});
            scene.states[0].velocity[0] = {1, 2, 0};
            scene = run(scene, 12, world, substeps);
            const Vec3 at(12 * dt, 10 + 24 * dt - parabola(12), 0);
            EXPECT_LT((scene.states[0].position[0] - at).norm(), 1e-9) << substeps;
            EXPECT_LT((scene.states[0].velocity[0] - Vec3(1, 2 - 12 * dt * g, 0)).norm(), 1e-9);
        }
    }
}

// Hinged limbs, drops of one substance and masses on springs fall as one.
TEST(LayeredFall, WhatIsLinkedFallsAsOne)
{
    LayeredBody drops = make_layered_body(
        soft_layer({point({0, 0, 0}), point({0.15, 0.1, 0}), point({2, 0, 0})}, true),
        BaseKind::particles, 1000, 0.05);
    LayeredBody springs = drops;
    add_spring_network(springs.base, 0.3, 500, 2);
    for (const LayeredBody& body : {two_limbs(-1, 1), drops, springs}) {
        LayeredScene scene = scene_of({body});
        scene.states[0].velocity[0] = {0.3, 0, 1};
        const Vec3 began = middle_of_mass(scene), drift = momentum(scene);
        double mass = 0;
        for (const double m : body.base.mass) mass += m;
        scene = run(scene, 10);
        const Vec3 at = began + 10 * dt * drift / mass - Vec3(0, parabola(10), 0);
        EXPECT_LT((middle_of_mass(scene) - at).norm(), 1e-7);
    }
}

// One is held, the other lets it go after six frames, from rest.
TEST(LayeredFall, WhatIsHeldDoesNotFallAndWhatIsReleasedFallsFromThere)
{
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(ball({0, 2, 0}));
    part.held = {{0, Vec3::Zero()}};
    LayeredScene scene = start({part});
    scene = run(scene, 6);
    EXPECT_LT((scene.states[0].position[0] - Vec3(0, 2, 0)).norm(), 1e-14);
    scene.parts[0].held.clear();
    scene = run(scene, 6);
    EXPECT_NEAR(scene.states[0].position[0].y(), 2 - parabola(6), 1e-9);
}

// A mass on a spring comes to rest where the spring carries its weight: m g / k below its length.
TEST(LayeredFall, WhatHangsOnASpringComesToRestWhereThatCarriesIt)
{
    LayeredBody body = make_layered_body(soft_layer({point({0, 0, 0}), point({0, -0.5, 0})}, true),
                                         BaseKind::particles, 1000, 0.05);
    add_spring_network(body.base, 0.6, 2000, 60);
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(body);
    part.held = {{0, Vec3::Zero()}};
    const LayeredScene scene = run(start({part}), 72);
    EXPECT_NEAR(scene.states[0].position[1].y(), -0.5 - body.base.mass[1] * g / 2000, 1e-6);
    EXPECT_LT(scene.states[0].velocity[1].norm(), 1e-5);
}

// v = g / c (1 - e^(-c t)); at the end the air carries it. Euler's steps are within dt c of it.
TEST(LayeredFall, WhatAirCarriesFallsAsFastAsItsVelocitySays)
{
    const LayeredWorld world{.drag = 4};
    const LayeredScene before = run(scene_of({ball({0, 0, 0})}), 72, world);
    const LayeredScene after = run(before, 24, world);
    const double speed = before.states[0].position[0].y() - after.states[0].position[0].y();
    EXPECT_NEAR(speed, g / 4, 1e-4);
    EXPECT_NEAR(after.states[0].velocity[0].y(), -g / 4, 1e-4);
}

// A ball that bounces off a floor below is where e = 1 brings it back to: its velocities lag while
// it touches, and have caught up when it flies.
TEST(LayeredFall, ABodyThatHasBouncedFliesAlongAParabola)
{
    LayeredBody body = ball({0, 0.6, 0}, 1e7, 0.02);
    LayeredScene scene = run(scene_of({body, floor_at(0)}), 10);
    const LayeredState one = scene.states[0];
    ASSERT_GT(one.velocity[0].y(), 0);
    ASSERT_EQ(one.lag, 0);
    scene = run(scene, 4);
    const double t = 4 * dt, y = one.position[0].y() + t * one.velocity[0].y() - 0.5 * g * t * t;
    EXPECT_NEAR(scene.states[0].position[0].y(), y, 1e-9);
}

// Near the position of a radial force its acceleration is -omega^2 x, and what is let go at x_0 is
// at x_0 cos(n angle) after n steps of drift, kick and drift (bricks/radial_on_way.hpp).
TEST(LayeredFall, WhatIsDrawnToAPlaceSwingsThroughItForEver)
{
    const double omega = 12, tau = dt / 2, angle = std::acos(1 - 0.5 * omega * omega * tau * tau);
    LayeredWorld world{.gravity = Vec3::Zero()};
    world.forces.push_back({.kind = Force::Kind::radial,
                            .position = Vec3::Zero(),
                            .radius = 1e4,
                            .outward = -omega * omega * 1e3});
    LayeredBody drops = make_layered_body(
        soft_layer({point({0.5, 0, 0}), point({0.65, 0.1, 0}), point({0.6, 0, 0.1})}, true),
        BaseKind::particles, 1000, 0.05);
    add_spring_network(drops.base, 0.3, 500, 2);
    for (const LayeredBody& body : {ball({0.6, 0, 0}), drops}) {
        for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
            if (solver == RigidBodies::bullet && body.base.kind != BaseKind::rigid) continue;
            world.rigid_bodies = solver;
            LayeredScene scene = scene_of({body});
            const Vec3 began = middle_of_mass(scene);
            for (int frame = 1; frame <= 72; ++frame) {
                scene = run(scene, 1, world);
                const Vec3 off = middle_of_mass(scene) - began * std::cos(2 * frame * angle);
                ASSERT_LT(off.norm(), 1e-4) << frame << " " << int(body.base.kind);
            }
        }
    }
}

// Its torque about its position is 0: what spins there is slowed by the steps alone.
TEST(LayeredFall, WhatSpinsAboutTheMiddleOfARadialForceGoesOnAsWithoutIt)
{
    LayeredBody body = make_layered_body(soft_layer({point({-0.1, 0, 0}), point({0.1, 0, 0}),
                                                     point({0, 0.1, 0}), point({0, -0.1, 0})},
                                                    true),
                                         BaseKind::particles, 1000, 0.05);
    add_spring_network(body.base, 0.3, 5e4, 2);
    const auto left = [&](double outward) {
        LayeredWorld world{.gravity = Vec3::Zero()};
        world.forces.push_back({.kind = Force::Kind::radial,
                                .position = Vec3::Zero(),
                                .radius = 1e4,
                                .outward = outward});
        LayeredScene scene = scene_of({body});
        for (std::size_t f = 0; f < scene.states[0].velocity.size(); ++f) {
            scene.states[0].velocity[f] = Vec3(0, 0, 6).cross(scene.states[0].position[f]);
        }
        return angular_momentum(run(scene, 24, world, 4)).z();
    };
    const double without = left(0);
    EXPECT_NEAR(left(-1e5) / without, 1, 0.02);
    EXPECT_NEAR(left(1e5) / without, 1, 0.02);
}

}  // namespace physics::layered_fall_test
