// Bounces of soft layers on rigid bodies, by either solver.

#include "physics/layered_bodies/layered_bounce.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using namespace layered_fixtures;

constexpr double g = 9.81;

LayeredBody rubber(const Vec3& at, double stiffness, double restitution, double times_mass = 1)
{
    LayeredBody body = ball(at, stiffness, 0.02);
    body.matter.restitution = restitution;
    body.base.mass[0] *= times_mass;
    body.base.inertia[0] *= times_mass;
    return body;
}

// How high above its first touch ball 0 rises after each of its bounces, m.
std::vector<double> rises(LayeredScene scene, const LayeredWorld& world, double dt, int bounces)
{
    std::vector<double> out;
    double last = 0, highest = 0;
    for (int frame = 0; frame < 400 && out.size() < static_cast<std::size_t>(bounces); ++frame) {
        scene = advance(scene, scene.parts, world, dt, 2);
        const LayeredState& state = scene.states[0];
        const double y = state.position[0].y() - 0.1;
        const double v = state.velocity[0].y() - 0.5 * state.lag * g;
        if (last > 0 && v < 0) out.push_back(highest);
        if (last <= 0 && v > 0) highest = 0;
        if (v > 0 && y > 0) highest = std::max(highest, y + 0.5 * v * v / g);
        last = v;
    }
    return out;
}

// It rises to e^2 of the height h, time after time.
void expect_bounces(const LayeredScene& scene, double h, double e, int bounces)
{
    const auto rise = rises(scene, {}, 1.0 / 24, bounces);
    ASSERT_EQ(rise.size(), static_cast<std::size_t>(bounces));
    for (const double height : rise) {
        EXPECT_LT(std::sqrt(height / h), (e < 1 ? 1.03 : 1.005) * e);
        EXPECT_GT(std::sqrt(height / h), 0.97 * e);
    }
}

// A rigid box whose layer's top is at 0, and whose side is at x = 0.
LayeredBody tile(double side)
{
    Skeleton box{.kind = SkeletonKind::box, .points = {}};
    box.half_size = {0.5, 0.1, 0.5};
    box.place.translate(Vec3(0.5 * side, -0.1 - soft.thickness, 0));
    LayeredBody body = make_layered_body(soft_layer({box}), BaseKind::still, 1, 0.1);
    body.matter.rigid = true;
    return body;
}

}  // namespace

// u' = -e u: it rises to e^2 h, whatever its layer's stiffness and its mass, in steps that are
// longer than the contact. Bounds of 3 % of the speed, of which less than 1 is met.
TEST(LayeredBounce, ABallRisesToESquaredOfItsHeight)
{
    constexpr double h = 0.5;
    for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
        const LayeredWorld world{.rigid_bodies = solver};
        for (const double stiffness : {1e5, 1e7}) {
            for (const double e : {0.5, 0.9, 1.0}) {
                const double dt = e == 0.9 ? 1.0 / 25 : 1.0 / 24;
                const double times = e == 0.5 ? 0.1 : stiffness == 1e7 ? 10 : 1;
                const auto rise =
                    rises(scene_of({rubber({0, 0.1 + h, 0}, stiffness, e, times), floor_at(0)}),
                          world, dt, 1);
                ASSERT_EQ(rise.size(), 1u);
                EXPECT_NEAR(std::sqrt(rise[0] / h), e, 0.03 * e)
                    << stiffness << ' ' << times << ' ' << (solver == RigidBodies::bullet);
            }
        }
    }
}

// With e = 0 it stays, and comes to where its layer carries it.
TEST(LayeredBounce, ABallWithoutRestitutionStaysAndRests)
{
    for (const double stiffness : {1e5, 1e7}) {
        const LayeredBody clay = rubber({0, 0.6, 0}, stiffness, 0);
        LayeredScene scene = scene_of({clay, floor_at(0)});
        double highest = 0;
        for (int frame = 0; frame < 40; ++frame) {
            scene = advance(scene, scene.parts, {}, 1.0 / 24, 2);
            if (frame > 9) highest = std::max(highest, scene.states[0].position[0].y());
        }
        // 3 % of the speed are 1e-3 of the height.
        EXPECT_LT(highest, 0.1 + 1e-3 * 0.5);
        EXPECT_LT(fastest(scene), 1e-3);
        EXPECT_NEAR(scene.states[0].position[0].y(), resting_height(clay), 1e-3);
    }
}

// e = 1 twenty times over: no energy is made.
TEST(LayeredBounce, TwentyBouncesMakeNoEnergy)
{
    const auto rise = rises(scene_of({rubber({0, 0.4, 0}, 1e6, 1), floor_at(0)}), {}, 1.0 / 24, 20);
    ASSERT_EQ(rise.size(), 20u);
    for (std::size_t i = 0; i < rise.size(); ++i) {
        EXPECT_LT(rise[i], 0.3 * 1.003) << i;
        EXPECT_GT(rise[i], 0.3 * 0.97) << i;
    }
}

// Nor does it matter how long a frame of the film is.
TEST(LayeredBounce, ABallBouncesInSlowMotion)
{
    const auto rise =
        rises(scene_of({rubber({0, 0.2, 0}, 1e6, 0.9), floor_at(0)}), {}, 1.0 / 240, 1);
    ASSERT_EQ(rise.size(), 1u);
    EXPECT_NEAR(std::sqrt(rise[0] / 0.1), 0.9, 0.03 * 0.9);
}

// The same of rigid layers, that give nothing.
TEST(LayeredBounce, ARigidBallRisesToESquaredOfItsHeight)
{
    constexpr double h = 0.5;
    for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
        for (const double e : {0.5, 0.9, 1.0}) {
            LayeredBody body = ball({0, 0.1 + h, 0}, 2e4, 0.02);
            body.matter.rigid = true;
            body.matter.bounce = e;
            const auto rise =
                rises(scene_of({body, floor_at(0)}), {.rigid_bodies = solver}, 1.0 / 24, 1);
            ASSERT_EQ(rise.size(), 1u);
            EXPECT_NEAR(std::sqrt(rise[0] / h), e, 0.03 * e) << (solver == RigidBodies::bullet);
        }
    }
}

// Of masses 1 and r, the first at V: v1 = V (1 - e r) / (1 + r), v2 = V (1 + e) / (1 + r).
TEST(LayeredBounce, TwoBallsShareTheirMomentumAsTheirRestitutionSays)
{
    constexpr double V = 2, r = 4;
    for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
        for (const double stiffness : {1e5, 1e7}) {
            for (const double e : {0.0, 0.5, 1.0}) {
                LayeredScene scene = scene_of(
                    {rubber({-0.15, 0, 0}, stiffness, e), rubber({0.15, 0, 0}, stiffness, e, r)});
                scene.states[0].velocity[0].x() = V;
                LayeredWorld world = weightless;
                world.rigid_bodies = solver;
                for (int i = 0; i < 12; ++i)
                    scene = advance(scene, scene.parts, world, 1.0 / 24, 2);
                const double v1 = scene.states[0].velocity[0].x();
                const double v2 = scene.states[1].velocity[0].x();
                EXPECT_NEAR(v1 + r * v2, V, 1e-9);
                EXPECT_NEAR(v1, V * (1 - e * r) / (1 + r), 0.03 * V) << stiffness << ' ' << e;
                EXPECT_NEAR(v2, V * (1 + e) / (1 + r), 0.03 * V) << stiffness << ' ' << e;
            }
        }
    }
}

// Layers in series store energy as the inverse of their stiffnesses, 3 to 1 here, and give back
// e_i^2 of it: e^2 = (3 * 0.2^2 + 1) / 4.
TEST(LayeredBounce, TheSofterLayerDecides)
{
    LayeredBody one = rubber({-0.15, 0, 0}, 1e6, 0.2), two = rubber({0.15, 0, 0}, 3e6, 1);
    LayeredScene scene = scene_of({one, two});
    scene.states[0].velocity[0].x() = 2;
    for (int i = 0; i < 12; ++i) scene = advance(scene, scene.parts, weightless, 1.0 / 24, 2);
    const double parting = scene.states[1].velocity[0].x() - scene.states[0].velocity[0].x();
    EXPECT_NEAR(parting / 2, std::sqrt((3 * 0.04 + 1) / 4), 0.01);
}

// Two balls stand on each other on a floor; nothing moves them, though their layers lose nothing.
TEST(LayeredBounce, AStackStaysAtRest)
{
    LayeredBody below = rubber({0, 0.098, 0}, 1e6, 1), above = rubber({0, 0.295, 0}, 1e6, 1);
    below.matter.friction = above.matter.friction = 100;
    LayeredScene scene = scene_of({below, above, floor_at(0)});
    double most = 0;
    for (int frame = 0; frame < 48; ++frame) {
        scene = advance(scene, scene.parts, {}, 1.0 / 24, 2);
        if (frame >= 24) most = std::max(most, fastest(scene));
    }
    EXPECT_LT(most, 2e-3);
}

// Two skeletons on one frame share its mass: as one ball, e = 1 makes nothing in eight bounces.
TEST(LayeredBounce, ADumbbellBouncesAsABall)
{
    for (const double stiffness : {1e5, 1e7}) {
        for (const double e : {0.5, 1.0}) {
            LayeredBody body =
                make_layered_body(soft_layer({point({-0.12, 0.4, 0}), point({0.12, 0.4, 0})}),
                                  BaseKind::rigid, 1000, 0.03);
            body.matter.stiffness = stiffness;
            body.matter.friction = 0;
            body.matter.restitution = e;
            expect_bounces(scene_of({body, floor_at(0)}), 0.3, e, e < 1 ? 1 : 8);
        }
    }
}

// Nor does it matter how many skeletons carry what a ball falls on: here two boxes meet below it.
TEST(LayeredBounce, ABallBouncesOnASeam)
{
    for (const double stiffness : {1e5, 1e7}) {
        for (const double e : {0.5, 1.0}) {
            expect_bounces(scene_of({rubber({0, 0.4, 0}, stiffness, e), tile(-1), tile(1)}), 0.3, e,
                           e < 1 ? 1 : 8);
        }
    }
}

// What damps a layer that rests does not brake a ball that rolls: it gets as far as one that is not
// damped.
TEST(LayeredBounce, ABallWithoutRestitutionRolls)
{
    const auto way = [](double e) {
        LayeredBody body = rubber({0, 0, 0}, 1e6, e);
        body.base.frames[0].translation().y() = resting_height(body);
        body.matter.friction = 1000;
        LayeredScene scene = scene_of({body, floor_at(0)});
        scene.states[0].position[0].y() = resting_height(body);
        scene.states[0].velocity[0].x() = 1;
        scene.states[0].spin[0].z() = -10;
        for (int frame = 0; frame < 24; ++frame) {
            scene = advance(scene, scene.parts, {}, 1.0 / 24, 2);
        }
        return scene.states[0].position[0].x();
    };
    EXPECT_GT(way(1), 0.5);
    EXPECT_NEAR(way(0) / way(1), 1, 0.05);
}

// What is slow depends on the layer that gives, not on the rigid one, whichever comes first.
TEST(LayeredBounce, TheOrderOfBodiesDoesNotMatter)
{
    const auto parting = [](bool rigid_first) {
        ImplicitLayer thick = soft_layer({point({0.3, 0, 0})});
        thick.contributions[0] = {.thickness = 0.3, .stiffness = 10, .radius = 0.42};
        LayeredBody stone = make_layered_body(thick, BaseKind::rigid, 1000, 0.1);
        stone.matter.rigid = true;
        stone.matter.friction = 0;
        LayeredBody soft_one = rubber({-0.15, 0, 0}, 1e6, 0.9);
        const std::size_t a = rigid_first ? 1 : 0, b = 1 - a;
        LayeredScene scene =
            rigid_first ? scene_of({stone, soft_one}) : scene_of({soft_one, stone});
        scene.states[a].velocity[0].x() = 0.5;
        for (int i = 0; i < 24; ++i) scene = advance(scene, scene.parts, weightless, 1.0 / 24, 2);
        return scene.states[b].velocity[0].x() - scene.states[a].velocity[0].x();
    };
    EXPECT_NEAR(parting(false), 0.9 * 0.5, 0.03 * 0.5);
    EXPECT_NEAR(parting(true), 0.9 * 0.5, 0.03 * 0.5);
}

// Weight of a field of forces is weight.
TEST(LayeredBounce, ABallBouncesUnderAFieldOfGravity)
{
    const LayeredWorld world{.gravity = Vec3::Zero(), .forces = {Force{}}};
    const auto rise =
        rises(scene_of({rubber({0, 0.6, 0}, 1e6, 0.9), floor_at(0)}), world, 1.0 / 24, 1);
    ASSERT_EQ(rise.size(), 1u);
    EXPECT_NEAR(std::sqrt(rise[0] / 0.5), 0.9, 0.03 * 0.9);
}

// Steps get shorter while a layer bounces, and only then.
TEST(LayeredBounce, OnlyBouncesTakeShorterSteps)
{
    LayeredScene scene = scene_of({rubber({0, 0.6, 0}, 1e7, 0.5), floor_at(0)});
    int most = 0, last = 0;
    for (int frame = 0; frame < 48; ++frame) {
        scene = advance(scene, scene.parts, {}, 1.0 / 24, 2);
        last = scene.states[0].report.steps;
        most = std::max(most, last);
    }
    EXPECT_GT(most, 8);
    EXPECT_LT(most, 64);
    EXPECT_EQ(last, 2);
}

// A heavy ball that lands in a deep, soft layer is stopped by its skeleton alone and stays there:
// that is told. One with a layer that can stop it is silent.
TEST(LayeredBounce, ALayerThatIsSpentIsTold)
{
    const auto warnings = [](double stiffness) {
        Skeleton box{.kind = SkeletonKind::box, .points = {}};
        box.half_size = {0.5, 0.1, 0.5};
        box.place.translate(Vec3(0, -0.1 - soft.thickness, 0));
        LayeredBody bed = make_layered_body(soft_layer({box}), BaseKind::still, 1, 0.1);
        bed.matter.stiffness = stiffness;
        LayeredScene scene = scene_of({rubber({0, 1, 0}, stiffness, 0.5), bed});
        std::vector<std::string> out;
        for (int frame = 0; frame < 16; ++frame) {
            scene = advance(scene, scene.parts, {}, 1.0 / 24, 2);
            for (const auto& state : scene.states) {
                out.insert(out.end(), state.report.warnings.begin(), state.report.warnings.end());
            }
        }
        return out;
    };
    const auto told = warnings(2e3);
    ASSERT_FALSE(told.empty());
    EXPECT_NE(told[0].find("The layer of body 0 is pressed down to its skeleton by body 1"),
              std::string::npos)
        << told[0];
    EXPECT_TRUE(warnings(1e6).empty());
}

}  // namespace physics
