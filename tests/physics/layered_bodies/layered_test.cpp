#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered.hpp"

#include "geometry/mesh/primitive.hpp"
#include "physics/layered_bodies/substance_parts.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using geometry::BlendRule;
using namespace layered_fixtures;

using std::numbers::pi;

LayeredScene advance(const LayeredScene& scene, const LayeredWorld& world, double dt, int substeps)
{
    return physics::advance(scene, scene.parts, world, dt, substeps);
}

}  // namespace

TEST(Layered, MassCentreAndInertiaComeFromTheTerritories)
{
    const LayeredBody body = ball({1, 2, 3});
    const double mass = 1000 * 4 * pi / 3 * 1e-3;
    EXPECT_NEAR(body.base.mass[0], mass, 1e-8);
    EXPECT_LT((body.base.frames[0].translation() - Vec3(1, 2, 3)).norm(), 1e-12);
    // Ball: 2/5 m r^2. Samples' directions are evenly spread, not exact for second moments.
    EXPECT_LT((body.base.inertia[0] - 0.4 * mass * 0.01 * geometry::Mat3::Identity()).norm(),
              1e-3 * body.base.inertia[0].norm());
}

TEST(Layered, ABallFallsFreely)
{
    LayeredScene scene = scene_of({ball({0, 10, 0})});
    for (int i = 0; i < 100; ++i) scene = advance(scene, {}, 0.01, 1);
    EXPECT_NEAR(scene.states[0].velocity[0].y(), -9.81, 1e-10);
    EXPECT_NEAR(scene.states[0].position[0].y(), 10 - 9.81 / 2, 1e-9);
}

TEST(Layered, ABallComesToRestWhereItsLayerCarriesIt)
{
    LayeredBody soft_ball = ball({0, 0.12, 0}, 2e4, 0.01);
    soft_ball.matter.friction = 2e4;
    LayeredScene scene = scene_of({soft_ball, floor_at(0)});
    for (int i = 0; i < 200; ++i) scene = advance(scene, {}, 1.0 / 60, 2);
    EXPECT_LT(scene.states[0].velocity[0].norm(), 1e-4);
    // Some 200 samples share the contact: a hundredth of the depth of 0.03.
    EXPECT_NEAR(scene.states[0].position[0].y(), resting_height(soft_ball), 3e-4);
}

TEST(Layered, MomentumIsKeptThroughACollision)
{
    LayeredScene scene = scene_of({ball({-0.15, 0, 0}), ball({0.15, 0.05, 0})});
    scene.states[0].velocity[0] = {2, 0, 0};
    const Vec3 before = momentum(scene), turning = angular_momentum(scene);
    double touched = 0;
    for (int i = 0; i < 60; ++i) {
        scene = advance(scene, weightless, 1.0 / 120, 1);
        touched = std::max(touched, scene.states[1].velocity[0].norm());
    }
    EXPECT_GT(touched, 0.5);
    EXPECT_LT((momentum(scene) - before).norm(), 1e-8 * before.norm());
    // Kept by each force; a step's own second-order error in positions remains.
    EXPECT_LT((angular_momentum(scene) - turning).norm(), 0.02 * before.norm() * 0.3);
}

TEST(Layered, StaysStableWhenStiffSoftOrSteppedFarTooFar)
{
    for (const double stiffness : {1e2, 1e4, 1e8}) {
        for (const double dt : {1.0 / 240, 1.0 / 24, 10.0 / 24}) {
            LayeredScene scene = scene_of(
                {ball({0, 0.3, 0}, stiffness), ball({0.02, 0.6, 0}, stiffness), floor_at(0)});
            for (int i = 0; i < 40; ++i) {
                scene = advance(scene, {}, dt, 1);
                for (std::size_t b = 0; b < 2; ++b) {
                    ASSERT_TRUE(scene.states[b].position[0].allFinite());
                    // Nothing is faster than what has fallen all the while.
                    ASSERT_LT(scene.states[b].velocity[0].norm(), 9.81 * dt * (i + 1) + 5);
                }
            }
        }
    }
}

TEST(Layered, AHingeHoldsAndStopsAtItsLimit)
{
    LayeredScene scene = scene_of({two_limbs(-0.5, 0.5)});
    scene.states[0].spin[1] = {0, 0, 3};
    const Vec3 turning = angular_momentum(scene);
    double widest = 0;
    for (int i = 0; i < 100; ++i) {
        scene = advance(scene, weightless, 1.0 / 60, 2);
        const HingeState hinge = hinge_state(scene);
        EXPECT_LT(hinge.gap, 2e-3);
        widest = std::max(widest, std::abs(hinge.angle));
    }
    EXPECT_GT(widest, 0.3);
    EXPECT_LT(widest, 0.6);
    EXPECT_LT(momentum(scene).norm(), 1e-6);
    EXPECT_LT((angular_momentum(scene) - turning).norm(), 0.1 * turning.norm());
}

TEST(Layered, VolumeIsHeldWhileTwoSkeletonsBlend)
{
    ImplicitLayer layer = soft_layer({point({-0.12, 0, 0}), point({0.12, 0, 0})}, true);
    LayeredBody body = make_layered_body(layer, BaseKind::still, 1000, 0.01);
    body.control = {.proportional = 20, .derivative = 0};
    const double target = body.volume[0] + body.volume[1];
    const auto closed_in = [&](double proportional, double derivative) {
        LayeredBody own = body;
        own.control = {proportional, derivative};
        LayeredScene scene = scene_of({own});
        double worst = 0;
        for (int i = 1; i <= 48; ++i) {  // 0.24 to 0.08 apart in two seconds
            std::vector<Transform> at(2, Transform::Identity());
            at[0].translate(Vec3(0.04 * i / 24.0, 0, 0));
            at[1].translate(Vec3(-0.04 * i / 24.0, 0, 0));
            scene.parts[0].frames = at;
            scene = advance(scene, weightless, 1.0 / 24, 1);
            const double now = scene.states[0].volume[0] + scene.states[0].volume[1];
            worst = std::max(worst, std::abs(now / target - 1));
        }
        return worst;
    };
    EXPECT_GT(closed_in(0, 1), 0.2);  // blending alone swells
    // What the controllers left is mended at the end of the frame, to a thousandth.
    EXPECT_LT(closed_in(20, 0), 1e-3);
    EXPECT_LT(closed_in(20, 1), 1e-3);
}

TEST(Layered, AChangingInflationIsFollowedAtEveryFrame)
{
    LayeredBody body =
        make_layered_body(soft_layer({point({0, 0, 0})}), BaseKind::still, 1000, 0.02);
    body.control = {.proportional = 10};
    LayeredScene scene = scene_of({body});
    for (int i = 1; i <= 24; ++i) {
        std::vector<LayeredPart> told = scene.parts;
        told[0].inflation = 1 + 0.3 * std::sin(0.5 * i);
        scene = advance(scene, told, weightless, 1.0 / 24, 3);
        EXPECT_NEAR(scene.states[0].volume[0] / body.volume[0], told[0].inflation, 1.3e-3);
        EXPECT_LT(volume_error(scene), 1e-3);
    }
}

TEST(Layered, AnInflationIsReached)
{
    LayeredBody body =
        make_layered_body(soft_layer({point({0, 0, 0})}), BaseKind::still, 1000, 0.02);
    body.control = {.proportional = 10};
    LayeredScene scene = scene_of({body});
    scene.parts[0].inflation = 1.3;
    for (int i = 0; i < 60; ++i) scene = advance(scene, weightless, 1.0 / 24, 1);
    EXPECT_NEAR(scene.states[0].volume[0], 1.3 * 4 * pi / 3 * 1e-3, 1e-6);
}

namespace {

LayeredBody dough(const std::vector<Vec3>& at)
{
    std::vector<Skeleton> skeletons;
    for (const Vec3& p : at) skeletons.push_back(point(p));
    ImplicitLayer layer = soft_layer(skeletons, true);
    layer.blend.rule = BlendRule::smooth_groups;
    layer.blend.part.assign(at.size(), 0);
    LayeredBody body = make_layered_body(layer, BaseKind::particles, 1000, 0.04);
    body.base.substance = {.stiffness = 20, .rest_distance = 0.15, .friction = 20, .reach = 2.5};
    body.matter.self_contact = true;
    body.matter.friction = 1e3;
    return body;
}

}  // namespace

TEST(Layered, ParticlesSettleAtTheirDistance)
{
    LayeredScene scene = scene_of({dough({{0, 0, 0}, {0.2, 0, 0}})});
    for (int i = 0; i < 200; ++i) scene = advance(scene, weightless, 1.0 / 24, 2);
    EXPECT_NEAR((scene.states[0].position[0] - scene.states[0].position[1]).norm(), 0.15, 1e-3);
}

// The change of velocity of two particles that are let go, over a short step: of the law in
// base.hpp, with the mass that their layers have.
TEST(Layered, ParticlesPullAndPushByTheirLaw)
{
    for (const double share : {0.5, 0.8, 1.0, 1.4, 2.2}) {
        LayeredBody body = dough({{0, 0, 0}, {0.15 * share, 0, 0}});
        body.base.substance.friction = 0;
        const double dt = 1e-6, mass = body.base.mass[0];
        const LayeredScene scene = advance(scene_of({body}), weightless, dt, 1);
        const double q = std::pow(1 / share, 4), w = 1 - share * share / 6.25;
        const double force = 20 * (q * q - q) * w * w;
        EXPECT_NEAR(-scene.states[0].velocity[0].x() * mass / dt, force,
                    1e-3 * std::abs(force) + 1e-6)
            << share;
    }
}

// With every rule of blending: those that only blend have no record of what came apart.
TEST(Layered, PiecesAreChainsOfOverlappingInfluences)
{
    for (const geometry::BlendRule rule :
         {geometry::BlendRule::sum, geometry::BlendRule::smooth_groups}) {
        LayeredBody body = dough({{0, 0, 0}, {0.3, 0, 0}, {0.6, 0, 0}, {5, 0, 0}, {5.3, 0, 0}});
        body.base.substance.stiffness = 0;
        body.layer.blend.rule = rule;
        if (rule == geometry::BlendRule::sum) body.layer.blend.part.clear();
        LayeredScene scene = advance(scene_of({body}), weightless, 1e-3, 1);
        EXPECT_EQ(physics::piece_count(scene), 2u);
        scene.states[0].position[1].y() += 3;
        scene = advance(scene, weightless, 1e-3, 1);
        EXPECT_EQ(physics::piece_count(scene), 4u);
    }
}

TEST(Layered, StretchedParticlesReachFartherAlongTheirWideAxisOnly)
{
    for (const geometry::BlendRule rule :
         {geometry::BlendRule::sum, geometry::BlendRule::smooth_groups}) {
        for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, 1, 0)}) {
            LayeredBody body = dough({{0, 0, 0}, 1.0 * way});
            for (Skeleton& skeleton : body.layer.skeletons) skeleton.stretch(0, 0) = 5;
            body.base.substance.stiffness = 0;
            body.layer.blend.rule = rule;
            if (rule == geometry::BlendRule::sum) body.layer.blend.part.clear();
            const LayeredScene scene = advance(scene_of({body}), weightless, 1e-3, 1);
            EXPECT_EQ(physics::piece_count(scene), way.x() > 0 ? 1u : 2u) << way.transpose();
        }
    }
}

TEST(Layered, PiecesThatCameApartCollideAndFuseUnderPressureOnly)
{
    for (const bool fuses : {false, true}) {
        LayeredBody body = dough({{0, 0, 0}, {0.15, 0, 0}});
        body.base.substance.stiffness = 0;
        body.base.substance.friction = 0;
        body.base.substance.fusion_threshold = fuses ? 100 : 1e30;
        body.base.substance.fusion_time = 0.02;
        LayeredScene scene = scene_of({body});
        const auto fly = [&](double speed, int frames) {
            scene.states[0].velocity = {{-speed, 0, 0}, {speed, 0, 0}};
            bool together = false;
            for (int i = 0; i < frames; ++i) {
                scene = advance(scene, weightless, 1.0 / 60, 1);
                together |= scene.states[0].part[0] == scene.states[0].part[1];
            }
            return together;
        };
        fly(1, 10);  // 0.48 apart: beyond 2 R
        EXPECT_NE(scene.states[0].part[0], scene.states[0].part[1]);
        const Vec3 before = momentum(scene);
        EXPECT_EQ(fly(-0.6, 60), fuses);
        if (!fuses) {
            EXPECT_TRUE(scene.states[0].links.empty());
            EXPECT_GT((scene.states[0].position[0] - scene.states[0].position[1]).norm(), 0.15);
        }
        EXPECT_LT((momentum(scene) - before).norm(), 1e-9);
    }
}

// While a pair of parts fuses, the field between them goes over from the larger to the sum without
// a jump in time, and its gradient without one in space.
TEST(Layered, TheSurfaceIsContinuousThroughFusion)
{
    ImplicitLayer layer = soft_layer({point({-0.09, 0, 0}), point({0.09, 0, 0})}, true);
    layer.blend.rule = BlendRule::smooth_groups;
    const std::vector<Transform> at(2, Transform::Identity());
    const Vec3 p(0, 0.04, 0), step(1e-8, 0, 0);
    double last = -1;
    for (int i = 0; i <= 1000; ++i) {
        layer.blend.links = {{0, 1, i / 1000.0}};
        const Field field = geometry::make_field(layer, at);
        const double f = geometry::value_at(field, p).f;
        if (i > 0) {
            EXPECT_LT(std::abs(f - last), 2e-3);  // d f / d beta <= f ln 2
        }
        last = f;
        if (i >= 10) {
            EXPECT_LT((geometry::value_at(field, p + step).gradient -
                       geometry::value_at(field, p - step).gradient)
                          .norm(),
                      1e-3);  // 2e-8 m times a second derivative of k^2 / beta = 1e4
        }
    }
}

// A ball that slides on a floor of grip mu loses mu g a second, however sticky the layer is; one
// without grip loses nothing.
TEST(Layered, FrictionOfARigidBodyFollowsItsCoefficient)
{
    for (const double grip : {0.0, 0.3}) {
        LayeredBody sliding = ball({0, 0.08, 0}, 2e4, 0.015), floor = floor_at(0);
        sliding.matter.friction = 2e4;
        floor.matter.grip = grip;
        LayeredScene scene = scene_of({sliding, floor});
        for (int i = 0; i < 200; ++i) scene = advance(scene, {}, 1.0 / 60, 2);
        scene.states[0].velocity[0] = {1, 0, 0};
        scene.states[0].spin[0].setZero();
        for (int i = 0; i < 6; ++i) scene = advance(scene, {}, 0.01, 4);
        EXPECT_NEAR(scene.states[0].velocity[0].x(), 1 - grip * 9.81 * 0.06, 0.02);
    }
}

// Between two plates that slide along at V a ball of mass m gets, in one step of backward Euler,
//   m dv = dt 2 lambda A (V - dv),   A the disc of either contact:   dv = V / 2 for lambda = m / (2
//   A dt)
TEST(Layered, FrictionOfAStepIsThatAtItsEnd)
{
    constexpr double dt = 1.0 / 240, speed = 0.3, half = 0.08;
    LayeredBody held = ball({0, 0, 0}, 2e4, 0.004);
    held.matter.friction = held.base.mass[0] / (2 * pi * (0.01 - half * half) * dt);
    Skeleton above{.kind = SkeletonKind::plane, .points = {}};
    above.place.translate(Vec3(0, half + soft.thickness, 0));
    above.place.rotate(Eigen::AngleAxisd(pi, Vec3::UnitX()));
    LayeredBody ceiling = make_layered_body(soft_layer({above}), BaseKind::still, 1, 0.1);
    ceiling.matter.rigid = true;
    LayeredScene scene = scene_of({held, floor_at(-half), ceiling});
    std::vector<LayeredPart> told = scene.parts;
    for (const std::size_t plate : {1u, 2u}) told[plate].pose.translate(Vec3(speed * dt, 0, 0));
    scene = physics::advance(scene, told, weightless, dt, 1);
    EXPECT_EQ(scene.states[0].report.steps, 1);
    EXPECT_NEAR(scene.states[0].velocity[0].x() / speed, 0.5, 2.5e-3);  // half of A's 3 (h/e)^2
    EXPECT_LT(scene.states[0].spin[0].norm(), 1e-9);
}

// A ball falls towards the floor while a plate under it rises faster than the floor alone would let
// it: both stops would be passed, but once the plate's holds, the floor's does not. In dt the ball
// must rise by what the plate does, 1/48 m, less what is left between: 0.015 - 0.01.
TEST(Layered, AStopReleasesWhenNotNeeded)
{
    LayeredScene scene = scene_of({ball({0, 0.02, 0}, 1), floor_at(0), floor_at(0.005)});
    scene.states[0].velocity[0] = {0, -0.4, 0};
    std::vector<LayeredPart> told = scene.parts;
    told[2].pose.translate(Vec3(0, 1.0 / 48, 0));
    scene = physics::advance(scene, told, weightless, 1.0 / 24, 1);
    EXPECT_EQ(scene.states[0].report.steps, 1);
    // Stops give way by a thousandth of what they hold back, some 0.03 m.
    EXPECT_NEAR(scene.states[0].position[0].y(), 0.02 + 1.0 / 48 - 0.005, 1e-4);
}

// Inside its limits a hinge is free: with and without them, the same bits. Beyond one it is driven
// back: the spring's stiffness of ten inertias a step squared leaves about a tenth.
TEST(Layered, AHingeFeelsItsLimitsOnlyBeyondThem)
{
    const auto after_a_step = [&](double lowest, double highest, double spin) {
        LayeredScene scene = scene_of({two_limbs(lowest, highest)});
        scene.states[0].spin[1] = {0, 0, spin};
        scene = advance(scene, weightless, 1.0 / 60, 1);
        return std::pair(scene.states[0].spin[1], hinge_state(scene).angle);
    };
    EXPECT_EQ(after_a_step(-0.01, 0.01, 3), after_a_step(-1e9, 1e9, 3));
    EXPECT_EQ(after_a_step(-0.01, 0.01, -3), after_a_step(-1e9, 1e9, -3));
    const double back = after_a_step(-0.5, -0.2, 0).second, on = after_a_step(0.2, 0.5, 0).second;
    EXPECT_LT(back, -0.1);
    EXPECT_GT(back, -0.2);
    EXPECT_NEAR(on, -back, 1e-9);
}

// What is told for a frame happens evenly in it: a plank that turns and strikes a ball, in one
// frame of four steps or in four of one.
TEST(Layered, AFrameOfSeveralStepsIsAsManyFramesOfOne)
{
    Collider plank;
    plank.kind = Collider::Kind::box;
    plank.half_size = {0.4, 0.05, 0.2};
    plank.friction = 0.5;
    const auto at = [&](double time) {
        Collider now = plank;
        now.pose.translate(Vec3(0.3 * time, 0, 0));
        now.pose.rotate(Eigen::AngleAxisd(1.5 * time, Vec3::UnitZ()));
        return rigid_part(now);
    };
    LayeredBody struck = ball({0.3, 0.16, 0});
    struck.matter.friction = 2e4;
    const LayeredScene begin =
        start({{.body = std::make_shared<const LayeredBody>(struck)}, at(0)});
    constexpr double dt = 1.0 / 24;
    LayeredScene whole = begin, quarters = begin;
    for (int i = 1; i <= 4; ++i) {
        whole = physics::advance(whole, {begin.parts[0], at(i * dt)}, weightless, dt, 4);
        for (int k = 1; k <= 4; ++k) {
            quarters = physics::advance(quarters, {begin.parts[0], at((i - 1 + 0.25 * k) * dt)},
                                        weightless, dt / 4, 1);
        }
        EXPECT_EQ(whole.states[0].report.steps, 4);
    }
    EXPECT_GT(whole.states[0].velocity[0].y(), 0.2);
    EXPECT_LT((whole.states[0].position[0] - quarters.states[0].position[0]).norm(), 1e-12);
    EXPECT_LT((whole.states[0].velocity[0] - quarters.states[0].velocity[0]).norm(), 1e-10);
}

// A plate that crosses a ball ten times over in one frame takes it along, as a box or as a mesh; a
// ball shot at a wall stays before it. What is too fast even so is told.
TEST(Layered, FastApproachesGetMoreSteps)
{
    Collider box, mesh;
    box.kind = Collider::Kind::box;
    box.half_size = {0.1, 1, 1};
    mesh.kind = Collider::Kind::mesh;
    const auto plate = [&](bool triangles, double from, double to) {
        if (!triangles) {
            Collider now = box;
            now.pose.translate(Vec3(to, 0, 0));
            return rigid_part(now);
        }
        Collider now = mesh;
        now.mesh = std::make_shared<geometry::TriMesh>(geometry::box({0.2, 2, 2}, {1, 1, 1}));
        auto before = std::make_shared<geometry::TriMesh>(*now.mesh);
        auto after = std::make_shared<geometry::TriMesh>(*now.mesh);
        for (auto& p : before->positions) p.x() += static_cast<float>(from);
        for (auto& p : after->positions) p.x() += static_cast<float>(to);
        now.mesh_before = before;
        now.mesh = after;
        return rigid_part(now);
    };
    for (const bool triangles : {false, true}) {
        LayeredScene scene = start({{.body = std::make_shared<const LayeredBody>(ball({0, 0, 0}))},
                                    plate(triangles, -0.4, -0.4)});
        scene = physics::advance(scene, {scene.parts[0], plate(triangles, -0.4, 0.6)}, weightless,
                                 1.0 / 24, 1);
        EXPECT_GT(scene.states[0].position[0].x(), 0.7) << triangles;
        EXPECT_LT(interpenetration(scene), 1e-3) << triangles;
        EXPECT_GT(scene.states[0].report.steps, 20) << triangles;
        EXPECT_TRUE(scene.states[0].report.warnings.empty());
    }
    LayeredScene scene = start(
        {{.body = std::make_shared<const LayeredBody>(ball({0, 0, 0}, 1e3))}, plate(false, 1, 1)});
    scene.states[0].velocity[0] = {48, 0, 0};
    scene = advance(scene, weightless, 1.0 / 24, 1);
    EXPECT_LT(scene.states[0].position[0].x(), 0.9);
    EXPECT_LT(interpenetration(scene), 1e-3);
    // Far from anything nothing needs to be met.
    scene = scene_of({ball({0, 0, 0}), floor_at(-100)});
    scene.states[0].velocity[0] = {1000, 0, 0};
    EXPECT_EQ(advance(scene, weightless, 1.0 / 24, 1).states[0].report.steps, 1);
    scene = scene_of({ball({0, 0, 0}), ball({3, 0, 0})});
    scene.states[0].velocity[0] = {1000, 0, 0};
    EXPECT_EQ(advance(scene, weightless, 1.0 / 24, 1).states[0].report.warnings.size(), 1u);
}

// What leads a layer, simulated cubes, goes into the floor: the layer's skeleton stays a tenth of
// its thickness above, and is where it is led again as soon as that is above the floor.
TEST(Layered, ALedLayerStaysOutOfObstacles)
{
    LayeredBody led = ball({0, 0.2, 0});
    led.base.kind = BaseKind::led;
    LayeredScene scene = scene_of({led, floor_at(0)});
    for (int i = 1; i <= 48; ++i) {
        const Vec3 at(0.01 * i, 0.2 - 0.3 * std::sin(pi * i / 24), 0);
        std::vector<LayeredPart> told = scene.parts;
        told[0].frames = {Transform(Eigen::Translation3d(at))};
        scene = physics::advance(scene, told, {}, 1.0 / 24, 2);
        EXPECT_LT(interpenetration(scene), 1e-3) << i;
        const Vec3 stands = scene.states[0].position[0];
        if (at.y() > 0.02) {
            EXPECT_LT((stands - at).norm(), 1e-5) << i;  // not pushed away by what it presses
        } else if (at.y() < 0) {
            EXPECT_NEAR(stands.y(), 0.01, 1e-3) << i;
            EXPECT_NEAR(stands.x(), at.x(), 1e-5) << i;
        }
    }
}

// One muscle of two flexes: its territory swells, the other keeps its own, to what the curvature of
// their volumes makes of a step; the whole is right.
TEST(Layered, AMuscleChangesItsOwnTerritory)
{
    ImplicitLayer layer = soft_layer({point({0, 0, 0}), point({0.5, 0, 0})});
    LayeredBody body = make_layered_body(layer, BaseKind::still, 1000, 0.02);
    body.control = {.proportional = 10};
    LayeredScene scene = scene_of({body});
    for (int i = 1; i <= 24; ++i) {
        std::vector<LayeredPart> told = scene.parts;
        told[0].muscle = {1 + 0.3 * std::sin(0.5 * i), 1};
        told[0].inflation = 1.1;
        scene = advance(scene, told, weightless, 1.0 / 24, 2);
        const double flexed = 1.1 * told[0].muscle[0];
        EXPECT_NEAR(scene.states[0].volume[0] / body.volume[0], flexed, 0.02) << i;
        EXPECT_NEAR(scene.states[0].volume[1] / body.volume[1], 1.1, 0.02) << i;
        EXPECT_LT(volume_error(scene), 1e-3);
    }
    std::vector<LayeredPart> wrong = scene.parts;
    wrong[0].muscle = {1, 1, 1};
    EXPECT_THROW(advance(scene, wrong, weightless, 1.0 / 24, 2), std::invalid_argument);
}

// A slab of triangles that goes sideways takes along what lies on it, at its own speed in the end.
TEST(Layered, ADeformingMeshCarriesWhatLiesOnIt)
{
    Collider slab;
    slab.kind = Collider::Kind::mesh;
    const geometry::TriMesh shape = geometry::box({4, 0.2, 4}, {1, 1, 1});
    const auto at = [&](double x) {
        auto mesh = std::make_shared<geometry::TriMesh>(shape);
        for (auto& p : mesh->positions) p.x() += static_cast<float>(x);
        return std::shared_ptr<const geometry::TriMesh>(mesh);
    };
    LayeredBody rider = ball({0, 0.19, 0});
    rider.matter.friction = 2e4;
    slab.mesh = at(0);
    LayeredScene scene =
        start({{.body = std::make_shared<const LayeredBody>(rider)}, rigid_part(slab)});
    constexpr double speed = 0.5, dt = 1.0 / 24;
    for (int i = 1; i <= 60; ++i) {
        slab.mesh_before = at(speed * dt * (i - 1));
        slab.mesh = at(speed * dt * i);
        scene = physics::advance(scene, {scene.parts[0], rigid_part(slab)}, {}, dt, 3);
    }
    // It rolls, too: a ball dragged at its foot from rest reaches 2/7 of the speed at once.
    EXPECT_GT(scene.states[0].velocity[0].x(), 0.25 * speed);
    EXPECT_LT(scene.states[0].velocity[0].x(), 1.05 * speed);
    EXPECT_NEAR(scene.states[0].position[0].y(), 0.18, 0.03);  // on top of the slab still
}

// 100 balls in one heap, most of them in each other: nothing is lost, nothing flies.
TEST(Layered, AHeapOfAHundredKeepsItsMomentum)
{
    std::vector<LayeredPart> parts;
    const auto body = std::make_shared<const LayeredBody>(ball({0, 0, 0}, 1e4, 0.07));
    for (int i = 0; i < 100; ++i) {
        LayeredPart part{.body = body};
        part.pose.translate(Vec3(0.11 * (i % 5), 0.11 * (i / 5 % 5), 0.11 * (i / 25 % 5)) +
                            0.02 * Vec3(std::sin(i), std::cos(2 * i), std::sin(3 * i)));
        part.velocity = {0.1 * std::cos(i), 0, 0};
        parts.push_back(part);
    }
    LayeredScene scene = start(parts);
    const Vec3 before = momentum(scene);
    const double mass = 100 * body->base.mass[0];
    for (int i = 0; i < 12; ++i) scene = advance(scene, weightless, 1.0 / 24, 1);
    ASSERT_EQ(scene.states.size(), 100u);
    EXPECT_GT(fastest(scene), 0.2);  // they drive each other apart
    EXPECT_LT(fastest(scene), 20);  // sqrt(2 K k d / rho r) of the deepest, as a ball alone is shot
    EXPECT_LT((momentum(scene) - before).norm(), 1e-8 * mass * fastest(scene));
}

// One skeleton wholly inside another object's: the two part, and end apart.
TEST(Layered, ASkeletonEntirelyInsideAnotherIsDrivenOut)
{
    for (const double dt : {1.0 / 48, 10.0 / 48}) {
        LayeredBody small = ball({0.01, 0.004, 0});
        small.matter.friction = 2e4;
        LayeredScene scene = scene_of({ball({0, 0, 0}), small});
        for (int i = 0; i < 60; ++i) {
            scene = advance(scene, weightless, dt, 1);
            ASSERT_TRUE(scene.states[1].position[0].allFinite());
            ASSERT_LT(fastest(scene), 50);
        }
        EXPECT_GT((scene.states[0].position[0] - scene.states[1].position[0]).norm(), 0.15);
    }
}

namespace {

// A box that is told where to be.
LayeredPart tool(const Vec3& size, const Vec3& at)
{
    Collider box;
    box.kind = Collider::Kind::box;
    box.half_size = 0.5 * size;
    box.pose.translate(at);
    return rigid_part(box);
}

}  // namespace

// A layer so soft that it holds nothing back: the skeleton itself is pushed along, by a box that is
// told where to be and by triangles that are made anew at each frame.
TEST(Layered, AToolThatReachesASkeletonPushesItAlong)
{
    const Vec3 size(0.06, 0.4, 0.4);
    const LayeredPart soft_ball{.body = std::make_shared<const LayeredBody>(ball({0, 0, 0}, 100))};
    const auto box_at = [&](double x) { return tool(size, {x, 0.03, 0}); };
    const geometry::TriMesh shape = geometry::box(size, {1, 1, 1});
    Collider mesh;
    mesh.kind = Collider::Kind::mesh;
    const auto mesh_at = [&](double x) {
        auto moved = std::make_shared<geometry::TriMesh>(shape);
        for (auto& p : moved->positions) p += geometry::Vec3f(static_cast<float>(x), 0.03f, 0);
        mesh.mesh_before = mesh.mesh;
        mesh.mesh = moved;
        return rigid_part(mesh);
    };
    for (const bool triangles : {false, true}) {
        const auto knife = [&](double x) { return triangles ? mesh_at(x) : box_at(x); };
        LayeredScene scene = start({soft_ball, knife(-0.25)});
        for (int i = 1; i <= 24; ++i) {  // 1 m/s
            scene = physics::advance(scene, {soft_ball, knife(-0.25 + i / 24.0)}, weightless,
                                     1.0 / 24, 4);
            ASSERT_LT(interpenetration(scene), 1e-3) << i << triangles;
        }
        EXPECT_GT(scene.states[0].position[0].x(), 0.75 + 0.03);  // ahead of the knife's face
        EXPECT_LT(scene.states[0].velocity[0].norm(), 1.5);
    }
}

// Two plates leave it a fifth of its thickness to either side, then a twentieth.
TEST(Layered, ASkeletonBetweenPlatesStaysBetweenThem)
{
    const LayeredPart soft_ball{.body = std::make_shared<const LayeredBody>(ball({0, 0, 0}, 100))};
    const auto plates = [&](double gap) {
        return std::vector<LayeredPart>{soft_ball, tool({0.6, 0.1, 0.6}, {0, 0.05 + gap, 0}),
                                        tool({0.6, 0.1, 0.6}, {0, -0.05 - gap, 0})};
    };
    LayeredScene scene = start(plates(0.12));
    for (int i = 1; i <= 40; ++i) {
        const double gap = 0.12 - 0.1 * std::min(1.0, i / 20.0) - (i > 30 ? 0.015 : 0);
        scene = physics::advance(scene, plates(gap), weightless, 1.0 / 24, 4);
        ASSERT_LT(interpenetration(scene), 1e-3) << i;
        EXPECT_NEAR(scene.states[0].position[0].y(), 0, 1e-3);
    }
}

// Thrown head-on with layers that hold nothing back, two skeletons do not pass through each other.
TEST(Layered, SkeletonsOfSoftBodiesDoNotPassEachOther)
{
    LayeredScene scene = scene_of({ball({-0.15, 0, 0}, 100), ball({0.15, 0, 0}, 100)});
    scene.states[0].velocity[0] = {2, 0, 0};
    scene.states[1].velocity[0] = {-1, 0, 0};
    const Vec3 before = momentum(scene);
    for (int i = 0; i < 24; ++i) {
        scene = advance(scene, weightless, 1.0 / 48, 2);
        ASSERT_LT(interpenetration(scene), 1e-3) << i;
        ASSERT_LT(scene.states[0].position[0].x(), scene.states[1].position[0].x()) << i;
    }
    EXPECT_LT((momentum(scene) - before).norm(), 1e-8 * before.norm());
}

TEST(Layered, ASpringNetworkJoinsNearFramesAndKeepsItsShape)
{
    LayeredBody body = dough({{0, 0, 0}, {0.15, 0, 0}, {0.15, 0.15, 0}, {0, 0.15, 0}});
    add_spring_network(body.base, 0.22, 2000, 20);
    EXPECT_EQ(body.base.springs.size(), 6u);  // sides and diagonals
    EXPECT_EQ(body.base.substance.stiffness, 0);
    LayeredScene scene = scene_of({body});
    scene.states[0].velocity[2] = {0.5, 0.5, 0};
    for (int i = 0; i < 240; ++i) scene = advance(scene, weightless, 1.0 / 24, 1);
    const auto& p = scene.states[0].position;
    EXPECT_NEAR((p[0] - p[1]).norm(), 0.15, 2e-3);
    EXPECT_NEAR((p[0] - p[2]).norm(), 0.15 * std::sqrt(2.0), 2e-3);
    EXPECT_THROW(add_spring_network(body.base, 0.01, 1, 1), std::invalid_argument);
}

TEST(Layered, TheSameBitsForAnyNumberOfThreads)
{
    std::vector<Vec3> ends;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        LayeredScene scene = scene_of({ball({0, 0.12, 0}), ball({0.05, 0.3, 0.01}), floor_at(0)});
        for (int i = 0; i < 20; ++i) scene = advance(scene, {}, 1.0 / 60, 1);
        ends.push_back(scene.states[1].position[0]);
    }
    EXPECT_EQ(ends[0], ends[1]);
    EXPECT_EQ(ends[0], ends[2]);
}

TEST(Layered, AFrameWithoutVolumeThrows)
{
    Skeleton plane{.kind = SkeletonKind::plane, .points = {}};
    EXPECT_THROW(make_layered_body(soft_layer({plane}), BaseKind::rigid, 1000, 0.1),
                 std::invalid_argument);
    EXPECT_THROW(make_layered_body(soft_layer({point({0, 0, 0})}), BaseKind::rigid, 0, 0.1),
                 std::invalid_argument);
    LayeredScene empty;
    EXPECT_TRUE(advance(empty, {}, 0.1, 1).parts.empty());
    EXPECT_THROW(physics::advance(scene_of({ball({0, 0, 0})}), {}, {}, 0.1, 1),
                 std::invalid_argument);
}

}  // namespace physics
