// Rigid bodies under layers, moved by Bullet.

#include "physics/layered_bodies/layered_bullet.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using namespace layered_fixtures;

const LayeredWorld by_bullet{.rigid_bodies = RigidBodies::bullet};
const LayeredWorld floating{.gravity = Vec3(0, 0, 0), .rigid_bodies = RigidBodies::bullet};

LayeredScene follow(LayeredScene scene, const LayeredWorld& world, double dt, int frames,
                    int substeps = 1)
{
    for (int i = 0; i < frames; ++i) {
        scene = physics::advance(scene, scene.parts, world, dt, substeps);
    }
    return scene;
}

double kinetic_energy(const LayeredScene& scene)
{
    double sum = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const Base& base = scene.parts[b].body->base;
        if (base.kind != BaseKind::rigid) continue;
        const LayeredState& state = scene.states[b];
        for (std::size_t f = 0; f < state.velocity.size(); ++f) {
            const Vec3 own = Eigen::Quaterniond(state.rotation[f]).conjugate() * state.spin[f];
            sum += 0.5 * base.mass[f] * state.velocity[f].squaredNorm() +
                   0.5 * own.dot(base.inertia[f] * own);
        }
    }
    return sum;
}

void expect_same(const LayeredScene& one, const LayeredScene& two)
{
    ASSERT_EQ(one.states.size(), two.states.size());
    for (std::size_t b = 0; b < one.states.size(); ++b) {
        const LayeredState &s = one.states[b], &t = two.states[b];
        EXPECT_EQ(s.position, t.position);
        EXPECT_EQ(s.rotation, t.rotation);
        EXPECT_EQ(s.velocity, t.velocity);
        EXPECT_EQ(s.spin, t.spin);
        EXPECT_EQ(s.distance, t.distance);
        EXPECT_EQ(s.pressed, t.pressed);
        EXPECT_EQ(s.steps_per_second, t.steps_per_second);
        EXPECT_EQ(s.report.steps, t.report.steps);
    }
}

// Two balls that hit each other off centre, and rub.
LayeredScene glancing(double friction)
{
    LayeredBody one = ball({-0.15, 0, 0}, 1e6), two = ball({0.15, 0.05, 0}, 1e6);
    one.matter.friction = two.matter.friction = friction;
    LayeredScene scene = scene_of({one, two});
    scene.states[0].velocity[0] = {2, 0, 0};
    return scene;
}

}  // namespace

// In a step of h, half of it before the weight acts and half after, x and v are exact for any h.
TEST(LayeredBullet, ABallFallsAsItShouldInOneStep)
{
    LayeredScene scene = scene_of({ball({0, 10, 0})});
    scene.states[0].velocity[0] = {1, 2, 0};
    scene = follow(scene, by_bullet, 1, 1);
    EXPECT_EQ(scene.states[0].report.steps, 1);
    EXPECT_LT((scene.states[0].position[0] - Vec3(1, 10 + 2 - 9.81 / 2, 0)).norm(), 1e-14);
    EXPECT_LT((scene.states[0].velocity[0] - Vec3(1, 2 - 9.81, 0)).norm(), 1e-14);
}

// dv/dt = -r v: exp(-r t) of the speed and of the spin are left, in steps of any length.
TEST(LayeredBullet, DragSlowsBodiesAtItsRate)
{
    LayeredWorld airy = floating;
    airy.drag = 0.7;
    LayeredScene scene = scene_of({ball({0, 0, 0})});
    scene.states[0].velocity[0] = {3, 0, 0};
    scene.states[0].spin[0] = {0, 0, 0.1};
    scene = follow(scene, airy, 0.25, 4);
    EXPECT_NEAR(scene.states[0].velocity[0].x(), 3 * std::exp(-0.7), 1e-12);
    // The ball's inertia differs by 1e-3 between axes: it wobbles.
    EXPECT_NEAR(scene.states[0].spin[0].norm(), 0.1 * std::exp(-0.7), 1e-4);
}

// Three unequal moments of inertia, thrown about the middle one: it tumbles over. Angular momentum
// is kept to round-off, energy to second order: a quarter of the error in steps half as long.
TEST(LayeredBullet, ATumblingBodyKeepsItsMomentumAndItsEnergy)
{
    LayeredScene scene =
        scene_of({make_layered_body(soft_layer({point({0, 0, 0}), point({0.3, 0, 0}),
                                                point({0.5, 0.02, 0}), point({0.1, 0.2, 0})}),
                                    BaseKind::rigid, 1000, 0.06)});
    const Eigen::SelfAdjointEigenSolver<geometry::Mat3> own(scene.parts[0].body->base.inertia[0]);
    scene.states[0].spin[0] = 6 * (own.eigenvectors().col(1) + 0.01 * own.eigenvectors().col(0));
    const Vec3 turning = angular_momentum(scene);
    const double energy = kinetic_energy(scene);
    double worst[2] = {0, 0};
    for (const int halves : {0, 1}) {
        LayeredScene now = scene;
        double turned = 0;
        const double dt = halves == 0 ? 0.02 : 0.01;
        for (int i = 0; i < 2 / dt; ++i) {
            now = follow(now, floating, dt, 1);
            EXPECT_EQ(now.states[0].report.steps, 1);
            EXPECT_LT((angular_momentum(now) - turning).norm(), 1e-12 * turning.norm());
            worst[halves] = std::max(worst[halves], std::abs(kinetic_energy(now) / energy - 1));
            turned = std::max(turned, (now.states[0].spin[0] - scene.states[0].spin[0]).norm());
        }
        EXPECT_GT(turned, 3);
    }
    EXPECT_LT(worst[0], 5e-3);
    EXPECT_NEAR(worst[0] / worst[1], 4, 0.8);
}

// Nothing rubs: a ball dropped by d keeps its energy g d in every bounce, stiff or soft, wherever
// in a frame it begins, and comes up to where it fell from. Some 1,300 samples come and go in the
// contact, and steps get shorter and longer: 2 %.
TEST(LayeredBullet, ABallBouncesBackToItsHeight)
{
    const double whole = 9.81 * 0.2;
    for (const double stiffness : {1e5, 1e8}) {
        for (const double dt : {0.02, 0.023, 1.0 / 24, 0.1}) {
            LayeredScene scene = scene_of({ball({0, 0.3, 0}, stiffness, 0.01), floor_at(0)});
            double highest = 0, worst = 0;
            for (double time = dt; time < 1; time += dt) {
                scene = follow(scene, by_bullet, dt, 1, 4);
                const double y = scene.states[0].position[0].y();
                const double v = scene.states[0].velocity[0].norm();
                if (time > 0.25) highest = std::max(highest, y + 0.5 * v * v / 9.81);
                if (y < 0.1) continue;
                const double energy = 0.5 * v * v + 9.81 * (y - 0.1);
                worst = std::max(worst, std::abs(energy / whole - 1));
            }
            EXPECT_LT(worst, 0.02) << stiffness << ' ' << dt;
            EXPECT_GT(highest, 0.3 - 0.02 * 0.2) << stiffness << ' ' << dt;
        }
    }
}

TEST(LayeredBullet, FrictionBringsABallToRestWhereItsLayerCarriesIt)
{
    LayeredBody soft_ball = ball({0, 0.12, 0}, 2e4, 0.01);
    soft_ball.matter.friction = 2e4;
    const LayeredScene scene =
        follow(scene_of({soft_ball, floor_at(0)}), by_bullet, 1.0 / 60, 120, 2);
    EXPECT_LT(scene.states[0].velocity[0].norm(), 1e-4);
    EXPECT_NEAR(scene.states[0].position[0].y(), resting_height(soft_ball), 3e-4);
}

// Every force acts on both balls at one point, and each goes straight in between: momentum and
// angular momentum are kept to round-off, and without friction energy to the bounce's 2 %.
TEST(LayeredBullet, MomentumIsKeptThroughACollision)
{
    for (const double friction : {0.0, 1e4, 1e7}) {
        const LayeredScene before = glancing(friction);
        const LayeredScene after = follow(before, floating, 0.01, 30, 2);
        EXPECT_GT(after.states[1].velocity[0].norm(), 0.5);
        EXPECT_LT((momentum(after) - momentum(before)).norm(), 1e-13 * momentum(before).norm());
        EXPECT_LT((angular_momentum(after) - angular_momentum(before)).norm(),
                  1e-13 * 0.15 * momentum(before).norm());
        const double kept = kinetic_energy(after) / kinetic_energy(before);
        if (friction == 0) {
            EXPECT_NEAR(kept, 1, 0.02);
        } else {
            EXPECT_LT(kept, 0.98);
        }
    }
}

// Seen from a plate that comes at V a ball at rest comes at -V and leaves at V: 2 V.
TEST(LayeredBullet, APlateThatComesOnThrowsABallAhead)
{
    Collider plate;
    plate.kind = Collider::Kind::box;
    plate.half_size = {0.1, 0.5, 0.5};
    plate.friction = 0;
    const auto at = [&](double x) {
        Collider now = plate;
        now.pose.translate(Vec3(x, 0, 0));
        return rigid_part(now);
    };
    const LayeredPart struck{.body =
                                 std::make_shared<const LayeredBody>(ball({0, 0, 0}, 1e7, 0.01))};
    LayeredScene scene = start({struck, at(-0.25)});
    for (int i = 1; i <= 15; ++i) {
        scene = physics::advance(scene, {struck, at(-0.25 + 0.01 * i)}, floating, 0.01, 1);
    }
    EXPECT_NEAR(scene.states[0].velocity[0].x(), 2, 0.04);
    EXPECT_NEAR(scene.states[1].position[0].x(), -0.1, 1e-12);
}

// One limb swings against the other, which rests, up to the limit and not beyond it. There both go
// on as one, without a bounce (until what throws them outward opens them again).
TEST(LayeredBullet, AHingeHoldsAndStopsAtItsLimit)
{
    for (const double spin : {3.0, -3.0}) {
        LayeredScene scene = scene_of({two_limbs(-0.2, 0.5)});
        scene.states[0].spin[1] = {0, 0, spin};
        scene.states[0].velocity[1] =
            Vec3(0, 0, spin).cross(scene.states[0].position[1] - Vec3(0.45, 0, 0));
        const Vec3 turning = angular_momentum(scene), going = momentum(scene);
        const double limit = spin > 0 ? 0.5 : -0.2;
        double farthest = 0, apart = 3;
        for (int i = 0; i < 120; ++i) {
            scene = follow(scene, floating, 1.0 / 120, 1, 4);
            const HingeState hinge = hinge_state(scene);
            // A step leaves r (w h)^2 / 4 at either arm, and the joint takes a fifth of all back:
            // up to 2.6e-5 m.
            EXPECT_LT(hinge.gap, 3e-5);
            farthest = std::max(farthest, hinge.angle / limit);
            if (std::abs(hinge.angle - limit) < 1e-3) {
                const Vec3 parting = scene.states[0].spin[1] - scene.states[0].spin[0];
                apart = std::min(apart, parting.norm());
            }
        }
        EXPECT_NEAR(farthest, 1, 1e-3);
        EXPECT_LT(apart, 0.03);
        EXPECT_LT((momentum(scene) - going).norm(), 1e-12 * going.norm());
        // A joint's impulses act where either limb has its point: 3e-5 m apart.
        EXPECT_LT((angular_momentum(scene) - turning).norm(), 1e-4 * turning.norm());
    }
}

// The same beside another body, whose frames come first.
TEST(LayeredBullet, AHingeJoinsTheLimbsOfItsOwnBody)
{
    LayeredBody limbs = two_limbs(-1, 1);
    limbs.base.hinges.clear();
    add_hinge(limbs.base, 1, 0, {0.45, 0, 0}, {0, 0, 1});
    LayeredScene scene = scene_of({limbs, ball({0, 3, 0}), limbs});
    for (const std::size_t b : {0u, 2u}) {
        LayeredState& state = scene.states[b];
        state.spin[1] = {0, 0, 2};
        state.velocity[1] = Vec3(0, 0, 2).cross(state.position[1] - Vec3(0.45, 0, 0));
    }
    scene.states[2].position[0].z() += 1;
    scene.states[2].position[1].z() += 1;
    scene = follow(scene, floating, 1.0 / 120, 30, 4);
    for (std::size_t f = 0; f < 2; ++f) {
        const Vec3 apart = scene.states[2].position[f] - scene.states[0].position[f];
        EXPECT_LT((apart - Vec3(0, 0, 1)).norm(), 1e-9) << f;
    }
    EXPECT_NEAR(scene.states[1].position[0].y(), 3, 1e-12);
}

// Limbs that mirror each other turn by a half of a small angle each, the centre staying where it
// is:
//   2 I/2 (a'/2)^2 + k a^2 / 2 = const:   w = sqrt(2 k / I), after a whole period where they were
TEST(LayeredBullet, LimbsOnASpringSwingAtTheirFrequency)
{
    LayeredBody body = two_limbs(-1e9, 1e9);
    const double stiffness = 20;
    body.base.hinges[0].stiffness = stiffness;
    body.base.hinges[0].rest = 0.05;
    const double inertia = 0.5 * (body.base.inertia[0](2, 2) + body.base.inertia[1](2, 2));
    const double period = 2 * std::numbers::pi / std::sqrt(2 * stiffness / inertia);
    LayeredScene scene = follow(scene_of({body}), floating, period / 64, 32);
    EXPECT_NEAR(hinge_state(scene).angle, 0.1, 1e-3);
    scene = follow(scene, floating, period / 64, 32);
    EXPECT_NEAR(hinge_state(scene).angle, 0, 1e-3);
}

// A layer that holds nothing back: the skeleton stops a tenth of its thickness before the floor.
TEST(LayeredBullet, ASkeletonStaysOutOfTheFloor)
{
    LayeredScene scene = scene_of({ball({0, 0.3, 0}, 100), floor_at(0)});
    for (int i = 0; i < 48; ++i) {
        scene = follow(scene, by_bullet, 1.0 / 24, 1, 2);
        ASSERT_LT(interpenetration(scene), 1e-3) << i;
    }
    EXPECT_NEAR(scene.states[0].position[0].y(), 0.01, 1e-3);
    EXPECT_LT(scene.states[0].velocity[0].norm(), 0.01);
}

// One that holds nothing back before a knife at 1 m/s: its skeleton is pushed along ahead of the
// face.
TEST(LayeredBullet, AToolThatReachesASkeletonPushesItAlong)
{
    Collider knife;
    knife.kind = Collider::Kind::box;
    knife.half_size = {0.03, 0.2, 0.2};
    const auto at = [&](double x) {
        Collider now = knife;
        now.pose.translate(Vec3(x, 0.03, 0));
        return rigid_part(now);
    };
    const LayeredPart soft_ball{.body = std::make_shared<const LayeredBody>(ball({0, 0, 0}, 100))};
    LayeredScene scene = start({soft_ball, at(-0.25)});
    for (int i = 1; i <= 24; ++i) {
        scene = physics::advance(scene, {soft_ball, at(-0.25 + i / 24.0)}, floating, 1.0 / 24, 4);
        ASSERT_LT(interpenetration(scene), 1e-3) << i;
    }
    EXPECT_GT(scene.states[0].position[0].x(), 0.75 + 0.03);
    EXPECT_LT(scene.states[0].velocity[0].norm(), 1.5);
}

// Nothing is remembered beside the state: going on from a copy of it, after others have moved too,
// gives the same bits.
TEST(LayeredBullet, TheStateHoldsAllThatTheNextStepNeeds)
{
    const LayeredScene halfway = follow(glancing(1e4), by_bullet, 0.01, 8, 2);
    const LayeredScene end = follow(halfway, by_bullet, 0.01, 8, 2);
    follow(scene_of({two_limbs(-0.1, 0.1)}), by_bullet, 0.01, 3);
    expect_same(follow(halfway, by_bullet, 0.01, 8, 2), end);
}

TEST(LayeredBullet, TheSameBitsForAnyNumberOfThreads)
{
    std::vector<LayeredScene> ends;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        ends.push_back(follow(scene_of({ball({0, 0.12, 0}), ball({0.05, 0.3, 0.01}), floor_at(0)}),
                              by_bullet, 1.0 / 60, 10));
    }
    expect_same(ends[0], ends[1]);
    expect_same(ends[0], ends[2]);
}

// K = 1e12 Pa asks for steps of some microseconds: there are 64 a frame. The log says so, and what
// would fly off without bound does not.
TEST(LayeredBullet, ForcesTooStiffForBulletAreWeakenedWithAWarning)
{
    LayeredScene scene = scene_of({ball({0, 0.11, 0}, 1e12), floor_at(0)});
    bool told = false;
    for (int i = 0; i < 24; ++i) {
        scene = follow(scene, by_bullet, 1.0 / 24, 1);
        ASSERT_TRUE(scene.states[0].position[0].allFinite());
        ASSERT_LT(scene.states[0].velocity[0].norm(), 1) << i;  // it fell at 0.44
        ASSERT_LE(scene.states[0].report.steps, 64);
        told |= !scene.states[0].report.warnings.empty() && !scene.states[0].report.converged;
    }
    EXPECT_TRUE(told);
}

TEST(LayeredBullet, BodiesThatBulletCannotMoveThrow)
{
    LayeredBody dough =
        make_layered_body(soft_layer({point({0, 0, 0})}), BaseKind::particles, 1000, 0.06);
    const LayeredScene scene = scene_of({ball({1, 0, 0}), dough});
    EXPECT_NO_THROW(check_rigid_bodies(scene.parts, RigidBodies::implicit));
    try {
        follow(scene, by_bullet, 0.01, 1);
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("body 1 is made of particles"), std::string::npos);
    }
    EXPECT_TRUE(follow({}, by_bullet, 0.01, 1).states.empty());
    const LayeredScene floor = follow(scene_of({floor_at(0)}), by_bullet, 0.01, 1);
    EXPECT_EQ(floor.states[0].report.steps, 1);
}

}  // namespace physics
