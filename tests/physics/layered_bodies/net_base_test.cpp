// Nets: segments and triangles that masses carry.

#include "physics/layered_bodies/net_base.hpp"

#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered_mesh.hpp"
#include "physics/layered_bodies/layered_volume.hpp"
#include "physics/layered_bodies/scene_record.hpp"
#include "physics/math/cross_matrix.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <random>

namespace physics {
namespace {

using namespace layered_fixtures;

Skeleton segment(const Vec3& a, const Vec3& b)
{
    return {.kind = SkeletonKind::segment, .points = {a, b}};
}

Skeleton triangle(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return {.kind = SkeletonKind::triangle, .points = {a, b, c}};
}

LayeredBody net(std::vector<Skeleton> skeletons, double spacing = 0.04)
{
    LayeredBody body = make_net_body(soft_layer(std::move(skeletons)), 1000, spacing);
    body.matter.stiffness = 2e4;
    body.matter.friction = 0;
    return body;
}

const Vec3 A(0, 0, 0), B(0.7, 0.1, 0), C(0.2, 0.1, 0.6), D(0.9, -0.2, 0.5);

// A segment on masses 0 and 1, and a triangle on 1, 2 and 3.
LayeredBody segment_and_triangle()
{
    return net({segment(A, B), triangle(B, C, D)});
}

TEST(NetBase, PointsAtOnePlaceAreOneMassAndWeighTheTerritories)
{
    const LayeredBody body = segment_and_triangle();
    EXPECT_EQ(mass_count(body.base), 4u);
    ASSERT_EQ(body.base.spans.size(), 2u);
    EXPECT_EQ(body.base.spans[0].masses, (std::vector<std::uint32_t>{0, 1}));
    EXPECT_EQ(body.base.spans[1].masses, (std::vector<std::uint32_t>{1, 2, 3}));
    double mass = 0, volume = 0;
    for (const double m : body.base.mass) mass += m;
    for (const double v : body.volume) volume += v;
    EXPECT_NEAR(mass / (1000 * volume), 1, 1e-9);
    // A segment alone: two masses alike, and with a third in line the middle one twice the sides.
    const LayeredBody line =
        net({segment(A, Vec3(2, 0, 0)), segment(Vec3(2, 0, 0), Vec3(4, 0, 0))});
    EXPECT_NEAR(line.base.mass[0] / line.base.mass[2], 1, 1e-6);
    const double pi = std::numbers::pi, tube = 1000 * pi * 0.01 * 2, cap = 1000 * pi * 2e-3 / 3;
    EXPECT_NEAR(line.base.mass[0] / (tube / 2 + cap), 1, 0.03);
    EXPECT_GT(line.base.mass[1], tube) << "it is thicker where two fields add up";
    EXPECT_LT(line.base.mass[1], 1.2 * tube);
}

// Positions of masses about where they are drawn, and what they carry.
struct Bent {
    LayeredBody body = segment_and_triangle();
    LayeredState state = scene_of({body}).states[0];
    std::mt19937 random{7};

    Vec3 any(double size)
    {
        std::uniform_real_distribution<double> within(-size, size);
        return {within(random), within(random), within(random)};
    }
    explicit Bent(double by)
    {
        for (std::size_t m = 0; m < mass_count(body.base); ++m) {
            state.position[m] += any(by);
            state.velocity[m] = any(1);
        }
        follow_masses(body, state);
    }
    Mat3 turn(std::size_t f) const
    {
        return Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
    }
};

TEST(NetBase, WhatAFrameFeelsKeepsItsForceAndTorque)
{
    Bent bent(0.2);
    const Base& base = bent.body.base;
    for (const std::size_t f : {4u, 5u}) {
        const NetHold hold = net_hold(base, f, bent.state.position, bent.turn(f));
        const auto& masses = base.spans[f - 4].masses;
        Vec6 wrench;
        wrench << bent.any(1), bent.any(1);
        Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
        for (std::size_t i = 0; i < masses.size(); ++i) {
            const Vec3 at = bent.state.position[masses[i]] - hold.middle;
            const Vec3 own = hold.by[i].transpose() * wrench;
            force += own, torque += at.cross(own);
        }
        Vec3 wanted = wrench.tail<3>();
        if (masses.size() == 2) {
            const Vec3 along = (bent.state.position[1] - bent.state.position[0]).normalized();
            wanted -= along * along.dot(wanted);
        }
        EXPECT_LT((force - wrench.head<3>()).norm(), 1e-13);
        EXPECT_LT((torque - wanted).norm(), 1e-13);
    }
}

TEST(NetBase, FramesMoveAndTurnAsTheirVelocitiesSay)
{
    const Bent bent(0.2);
    const double dt = 1e-6;
    LayeredState after = bent.state;
    for (std::size_t m = 0; m < mass_count(bent.body.base); ++m) {
        after.position[m] += dt * after.velocity[m];
    }
    follow_masses(bent.body, after);
    for (const std::size_t f : {4u, 5u}) {
        const Mat3 turned = Eigen::Quaterniond(after.rotation[f]).toRotationMatrix();
        const Mat3 rate = (turned - bent.turn(f)) / dt * bent.turn(f).transpose();
        const Vec3 moved = (after.position[f] - bent.state.position[f]) / dt;
        EXPECT_LT((rate - cross_matrix(bent.state.spin[f])).norm(), 1e-5);
        EXPECT_LT((moved - bent.state.velocity[f]).norm(), 1e-8);
    }
}

TEST(NetBase, SkeletonsReachFromMassToMass)
{
    const Bent bent(0.3);
    LayeredScene scene = scene_of({bent.body});
    scene.states[0] = bent.state;
    const LayeredMoment moment(scene);
    const auto& at = bent.state.position;
    const double c = moment.fields[0].isovalue;
    const auto value = [&](const Vec3& p) { return geometry::value_at(moment.fields[0], p).f; };
    // Beside the ends that nothing else is near to, and all along.
    const Vec3 aside = (at[1] - at[0]).cross(at[2] - at[3]).normalized();
    EXPECT_NEAR(value(at[0] + 0.1 * aside), c, 1e-9);
    EXPECT_NEAR(value(at[0] + 0.2 * (at[1] - at[0]) + 0.1 * aside), c, 1e-9);
    const Vec3 normal = (at[2] - at[1]).cross(at[3] - at[1]).normalized();
    EXPECT_NEAR(value(at[2] + 0.1 * normal), c, 1e-9);
    EXPECT_NEAR(value((at[2] + at[3]) / 2 - 0.1 * normal), c, 1e-9);
}

// Volumes of a net that was stretched are those of one drawn so, by samples of its own.
TEST(NetBase, VolumesStretchWithTheMasses)
{
    const Vec3 a(0.1, 0, 0), b(1.2, 0.1, 0.1), c(0.1, 0.2, 0.9);
    for (const bool plane : {false, true}) {
        const std::vector<Skeleton> rest{plane ? triangle(A, B, C) : segment(A, B)};
        const std::vector<Skeleton> told{plane ? triangle(a, b, c) : segment(a, b)};
        LayeredScene scene = scene_of({net(rest, 0.02)});
        scene.states[0].position[0] = a, scene.states[0].position[1] = b;
        if (plane) scene.states[0].position[2] = c;
        follow_masses(*scene.parts[0].body, scene.states[0]);
        const LayeredMoment moment(scene);
        const double stretched = local_volumes(moment.bodies, 0, moment.contacts)[0];
        EXPECT_NEAR(stretched / net(told, 0.02).volume[0], 1, plane ? 0.01 : 1e-3);
    }
}

// A chain hangs from its first mass: each spring is longer by the weight below it.
TEST(NetBase, AChainHangsByTheWeightBelowEachSpring)
{
    std::vector<Skeleton> links;
    for (int i = 0; i < 4; ++i) links.push_back(segment(Vec3(0, -i, 0), Vec3(0, -i - 1, 0)));
    LayeredBody body = net(std::move(links), 0.1);
    add_spring_skeletons(body.base, 5e3, 2e3);
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(body);
    part.held = {{0, Vec3::Zero()}};
    LayeredScene scene = start({part});
    for (int frame = 0; frame < 96; ++frame) scene = advance(scene, {part}, {}, 1.0 / 24, 1);
    const auto& at = scene.states[0].position;
    double below = 0;
    for (std::size_t m = 4; m-- > 0;) {
        below += body.base.mass[m + 1] * 9.81;
        EXPECT_NEAR((at[m] - at[m + 1]).norm(), 1 + below / 5e3, 1e-4);
    }
}

// A ball that rests on a plank between two springs, a quarter of its way from one of them.
TEST(NetBase, ALoadIsSharedByTheLever)
{
    LayeredBody body = net(
        {segment(Vec3(0, 0, 0), Vec3(2, 0, 0)), point(Vec3(0, 1, 0)), point(Vec3(2, 1, 0))}, 0.05);
    for (const std::uint32_t m : {0u, 1u}) {
        body.base.springs.push_back({m, m + 2, 1, 2e4, 3e3});
    }
    LayeredPart plank, weight;
    plank.body = std::make_shared<const LayeredBody>(body);
    plank.held = {{2, Vec3::Zero()}, {3, Vec3::Zero()}};
    weight.body = std::make_shared<const LayeredBody>(ball(Vec3(0.5, 0.19, 0), 2e5));
    LayeredScene scene = start({plank, weight});
    for (int frame = 0; frame < 30; ++frame) {
        scene = advance(scene, {plank, weight}, {}, 1.0 / 24, 2);
    }
    const LayeredState& state = scene.states[0];
    const double load = 9.81 * weight.body->base.mass[0], x = scene.states[1].position[0].x();
    for (const std::size_t m : {0u, 1u}) {
        const double share = m == 0 ? 1 - x / 2 : x / 2;
        const double wanted = 9.81 * body.base.mass[m] + share * load;
        const double carried = 2e4 * ((state.position[m + 2] - state.position[m]).norm() - 1);
        EXPECT_NEAR(carried / wanted, 1, 0.02) << "mass " << m;
    }
    EXPECT_NEAR(x, 0.5, 0.05) << "it slides down little";
}

// A triangle of masses and a ball fly into each other.
TEST(NetBase, ACollisionKeepsMomentum)
{
    LayeredBody body = net({triangle(A, B, C)});
    add_spring_skeletons(body.base, 1e4, 10);
    LayeredPart plate, shot;
    plate.body = std::make_shared<const LayeredBody>(body);
    shot.body = std::make_shared<const LayeredBody>(ball(Vec3(0.2, 0.4, 0.15)));
    shot.velocity = Vec3(0, -3, 0);
    const LayeredScene before = start({plate, shot});
    LayeredScene scene = before;
    const LayeredWorld nothing{.gravity = Vec3::Zero()};
    for (int frame = 0; frame < 8; ++frame) {
        scene = advance(scene, {plate, shot}, nothing, 1.0 / 24, 8);
    }
    EXPECT_GT(scene.states[0].spin[3].norm(), 0.1) << "hit beside its middle";
    EXPECT_LT((momentum(scene) - momentum(before)).norm(), 1e-8 * momentum(before).norm());
    const Vec3 turning = angular_momentum(before);
    EXPECT_LT((angular_momentum(scene) - turning).norm(), 0.02 * turning.norm());
}

// Nothing acts: nothing moves, and what blended blends still.
TEST(NetBase, AtRestItStaysWholeByEveryRuleOfBlending)
{
    using geometry::BlendRule;
    for (const BlendRule rule : {BlendRule::sum, BlendRule::largest_group, BlendRule::smooth_groups,
                                 BlendRule::gradient}) {
        ImplicitLayer layer =
            soft_layer({segment(A, Vec3(2, 0, 0)), segment(Vec3(2, 0, 0), Vec3(4, 0, 0))});
        layer.blend.rule = rule;
        layer.blend.part = {7, 7};
        LayeredBody body = make_net_body(layer, 1000, 0.05);
        body.matter.self_contact = true;
        add_spring_skeletons(body.base, 1e3, 1);
        LayeredScene scene = scene_of({body});
        for (int frame = 0; frame < 4; ++frame) {
            scene = advance(scene, scene.parts, {.gravity = Vec3::Zero()}, 1.0 / 24, 1);
        }
        EXPECT_EQ(scene.states[0].part, layer.blend.part);
        EXPECT_LT(fastest(scene), 1e-12);
    }
}

// A segment that pins draw out to thirteen times its length stops a ball at 10 m/s, in the middle
// and near its ends.
TEST(NetBase, WhatIsDrawnOutLetsNothingThrough)
{
    for (const double x : {0.0, 0.9}) {
        LayeredPart rope, shot;
        rope.body = std::make_shared<const LayeredBody>(
            net({segment(Vec3(-0.1, 0, 0), Vec3(0.1, 0, 0))}, 0.02));
        shot.body = std::make_shared<const LayeredBody>(ball(Vec3(x, 1.2, 0), 5e5));
        shot.velocity = Vec3(0, -10, 0);
        LayeredScene scene = start({rope, shot});
        for (int frame = 1; frame <= 6; ++frame) {
            const double out = std::min(1.0, frame / 2.0) * 1.2;
            rope.held = {{0, Vec3(-out, 0, 0)}, {1, Vec3(out, 0, 0)}};
            scene = advance(scene, {rope, shot}, {.gravity = Vec3::Zero()}, 1.0 / 24, 1);
        }
        EXPECT_GT(scene.states[1].position[0].y(), 0) << "at " << x;
        EXPECT_GT(scene.states[1].velocity[0].y(), 1) << "at " << x;
    }
}

TEST(NetBase, ARecordDrawsTheSameSurface)
{
    const Bent bent(0.2);
    LayeredScene scene = scene_of({bent.body});
    scene.states[0] = bent.state;
    const SceneRecord written = record(scene, "net");
    std::vector<std::string> files;
    for (const std::string& path : bodies_of_record(written.frame)) {
        files.push_back(written.bodies.at(path));
    }
    const LayeredScene read = read_record(written.frame, files);
    const LayeredMeshOptions options{.cell = 0.05};
    const geometry::TriMesh one = layered_mesh(scene, options), other = layered_mesh(read, options);
    EXPECT_EQ(one.positions, other.positions);
    EXPECT_GT(one.positions.size(), 100u);
}

std::string why(const std::function<void()>& what)
{
    try {
        what();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

TEST(NetBase, TellsWhatItCannotCarry)
{
    const Skeleton line{.kind = SkeletonKind::polyline, .points = {A, B, C}};
    EXPECT_EQ(why([&] {
                  net({segment(A, B), line});
              }).rfind("a net carries points, segments", 0),
              0u);
    EXPECT_EQ(why([&] { net({triangle(A, B, (A + B) / 2)}); }),
              "skeleton 0 (counted from 0) of the net has no area: move its points apart");
    EXPECT_EQ(why([&] { net({segment(A, A)}); }),
              "skeleton 0 (counted from 0) of the net has no length: move its points apart");
    Base loose;
    EXPECT_EQ(why([&] { add_spring_skeletons(loose, 1, 1); }).rfind("springs along skeletons", 0),
              0u);
}

}  // namespace
}  // namespace physics
