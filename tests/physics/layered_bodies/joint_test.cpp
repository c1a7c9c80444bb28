// Joints between rigid frames: against closed forms, with either solver.

#include "physics/layered_bodies/joint.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace physics::joint_test {
namespace {

using namespace layered_fixtures;

constexpr double pi = std::numbers::pi, g = 9.81, length = 0.4;
constexpr double step = 1.0 / 960;

LayeredWorld world_of(RigidBodies solver, const Vec3& gravity = {0, -g, 0})
{
    return {.gravity = gravity, .drag = 0, .rigid_bodies = solver};
}

// A ball of radius 0.1 m on a rod of `length` without weight, below a joint at the origin, turned
// by `angle` about z.
LayeredBody pendulum(JointKind kind, double angle)
{
    const Vec3 down(std::sin(angle), -std::cos(angle), 0);
    LayeredBody body = ball(length * down, 2e4, 0.08);
    add_joint(body.base, kind, Joint::world, 0, Vec3::Zero(), down, Vec3::UnitZ());
    return body;
}

// m L^2 + I of the ball about its middle, over m g L.
double swing_time(const LayeredBody& body)
{
    const double about = body.base.mass[0] * length * length + body.base.inertia[0](0, 0);
    return 2 * pi * std::sqrt(about / (body.base.mass[0] * g * length));
}

// Time between two passages of the lowest point, twice, s.
double measured_period(LayeredScene scene, RigidBodies solver)
{
    std::vector<double> passages;
    for (int i = 0; i < 4000 && passages.size() < 3; ++i) {
        const double before = scene.states[0].position[0].x();
        scene = advance(scene, scene.parts, world_of(solver), step, 1);
        const double after = scene.states[0].position[0].x();
        if (before * after < 0) passages.push_back((i + before / (before - after)) * step);
    }
    return passages.size() < 3 ? 0 : passages[2] - passages[0];
}

class EitherSolver : public testing::TestWithParam<RigidBodies> {};

INSTANTIATE_TEST_SUITE_P(Joints, EitherSolver,
                         testing::Values(RigidBodies::implicit, RigidBodies::bullet),
                         [](const auto& info) {
                             return info.param == RigidBodies::bullet ? "Bullet" : "Implicit";
                         });

}  // namespace

// The rows' lines and arms give the rates of their values.
TEST(Joint, RowsAreTheDerivativesOfTheirValues)
{
    LayeredBody body = two_limbs(-1, 1);
    const Vec3 at(0.45, 0.05, 0.02), first = Vec3(1, 2, -1).normalized();
    const Vec3 second = first.unitOrthogonal();
    for (const JointKind kind : {JointKind::ball, JointKind::slider, JointKind::two_axis}) {
        Joint& joint = add_joint(body.base, kind, 0, 1, at, first, second);
        joint.lowest = -1;
        joint.highest = 1;
        joint.cone = 1;
        // Out of place by little, so that what is held is near what it is held at.
        Transform a = body.base.frames[0], b = body.base.frames[1];
        b.rotate(Eigen::AngleAxisd(1e-3, Vec3(1, -1, 2).normalized())).translate(Vec3(1e-3, 0, 0));
        const Vec3 wa(0.3, -1, 0.7), wb(-0.5, 0.4, 1.1), va(1, 2, 3), vb(-1, 0.5, 2);
        const auto moved = [](Transform t, const Vec3& v, const Vec3& w, double dt) {
            const Vec3 to = t.translation() + dt * v;
            t.linear() = Eigen::AngleAxisd(dt * w.norm(), w.normalized()) * t.linear();
            t.translation() = to;
            return t;
        };
        const double h = 1e-6;
        const JointRows rows = joint_rows(joint, a, b);
        const JointRows after = joint_rows(joint, moved(a, va, wa, h), moved(b, vb, wb, h));
        const JointRows before = joint_rows(joint, moved(a, va, wa, -h), moved(b, vb, wb, -h));
        ASSERT_GE(rows.count, 4u);
        for (std::size_t r = 0; r < rows.count; ++r) {
            const JointRow& row = rows.rows[r];
            const double rate =
                row.angular ? row.along.dot(wb - wa)
                            : row.along.dot(vb + wb.cross(row.arm_b) - va - wa.cross(row.arm_a));
            const double numeric = (after.rows[r].value - before.rows[r].value) / (2 * h);
            // Turns of a thousandth of a radian leave as much of the rates.
            EXPECT_NEAR(rate, numeric, 5e-3) << "kind " << int(kind) << " row " << r;
        }
    }
}

TEST_P(EitherSolver, ABallJointSwingsAsAPendulum)
{
    const LayeredBody small = pendulum(JointKind::ball, 0.05),
                      wide = pendulum(JointKind::ball, 1.5);
    EXPECT_NEAR(measured_period(scene_of({small}), GetParam()), swing_time(small),
                0.01 * swing_time(small));
    // T = T0 / agm(1, cos(angle / 2)).
    double a = 1, b = std::cos(0.75);
    for (int i = 0; i < 6; ++i) {
        const double mean = 0.5 * (a + b);
        b = std::sqrt(a * b);
        a = mean;
    }
    // The implicit step loses some of the swing between these passages.
    const double loss = GetParam() == RigidBodies::bullet ? 0.001 : 0.01;
    EXPECT_NEAR(measured_period(scene_of({wide}), GetParam()), swing_time(wide) / a,
                loss * swing_time(wide) / a);
}

// Turned as a whole about the vertical at omega^2 = g / (L cos angle), whatever its inertia.
TEST_P(EitherSolver, ABallJointGoesRoundAsAConicalPendulum)
{
    const double angle = 0.6, omega = std::sqrt(g / (length * std::cos(angle)));
    LayeredScene scene = scene_of({pendulum(JointKind::ball, angle)});
    scene.states[0].spin[0] = omega * Vec3::UnitY();
    scene.states[0].velocity[0] = scene.states[0].spin[0].cross(scene.states[0].position[0]);
    const double period = 2 * pi / omega;
    const int steps = static_cast<int>(std::lround(period / step));
    double turned = 0, lowest = 1e9, highest = -1e9;
    for (int i = 0; i < steps; ++i) {
        const Vec3 before = scene.states[0].position[0];
        scene = advance(scene, scene.parts, world_of(GetParam()), step, 1);
        const Vec3& after = scene.states[0].position[0];
        turned += std::atan2(before.z() * after.x() - before.x() * after.z(),
                             before.x() * after.x() + before.z() * after.z());
        lowest = std::min(lowest, after.y());
        highest = std::max(highest, after.y());
    }
    EXPECT_NEAR(turned, 2 * pi * steps * step / period, 0.01 * 2 * pi);
    const double loss = GetParam() == RigidBodies::bullet ? 0.003 : 0.03;
    EXPECT_LT(highest - lowest, loss);  // m: it stays at its height
}

TEST_P(EitherSolver, ABallJointStopsAtItsCone)
{
    LayeredBody body = pendulum(JointKind::ball, 0);
    body.base.joints[0].cone = 0.4;
    LayeredScene scene = scene_of({body});
    scene.states[0].spin[0] = Vec3(3, 0, 4);
    scene.states[0].velocity[0] = scene.states[0].spin[0].cross(scene.states[0].position[0]);
    double widest = 0;
    for (int i = 0; i < 300; ++i) {
        scene = advance(scene, scene.parts, world_of(GetParam()), step, 1);
        const Vec3 at = scene.states[0].position[0].normalized();
        widest = std::max(widest, std::acos(-at.y()));
    }
    EXPECT_GT(widest, 0.39);
    EXPECT_LT(widest, 0.42);
}

// Falls along `way` for half a second, to 0.3 m at most: s = g sin(slope) t^2 / 2, up to its limit.
void expect_slide(const LayeredBody& body, const Vec3& way, RigidBodies solver)
{
    const double slope = std::asin(-way.y()), highest = 0.3;
    LayeredScene scene = scene_of({body});
    const Vec3 start = scene.states[0].position[0];
    for (int i = 1; i <= 480; ++i) {
        scene = advance(scene, scene.parts, world_of(solver), step, 1);
        const Vec3 gone = scene.states[0].position[0] - start;
        const double t = i * step, s = 0.5 * g * std::sin(slope) * t * t;
        if (s < 0.99 * highest) {
            // Half a step's speed early or late.
            EXPECT_NEAR(gone.dot(way), s, 0.6 * step * g * std::sin(slope) * t + 1e-6);
        }
        EXPECT_LT((gone - gone.dot(way) * way).norm(), 1e-4);
        EXPECT_LT(gone.dot(way), 1.01 * highest);
        // Its limit holds it beside its middle: that is given way to by as much as a step leaves.
        const Eigen::Quaterniond turn(scene.states[0].rotation[0]);
        EXPECT_LT(turn.angularDistance(Eigen::Quaterniond::Identity()), 5e-3);
    }
    EXPECT_NEAR((scene.states[0].position[0] - start).dot(way), highest, 0.01 * highest);
}

TEST_P(EitherSolver, ASliderFallsAlongItsSlopeWithoutTurning)
{
    // Along its axis up to the highest value, and against it down to the lowest.
    const Vec3 way(std::cos(0.5), -std::sin(0.5), 0);
    for (const double along : {1.0, -1.0}) {
        LayeredBody body = ball(Vec3(0.1, 0.2, 0), 2e4, 0.08);
        const Vec3 axis = along * way;
        Joint& joint = add_joint(body.base, JointKind::slider, Joint::world, 0, {0, 0, 0.3}, axis);
        (along > 0 ? joint.highest : joint.lowest) = along * 0.3;
        expect_slide(body, way, GetParam());
    }
}

TEST_P(EitherSolver, TwoAxesTurnAboutBothAndNotAboutTheThird)
{
    // As drawn it hangs along y; the axes are x, which the world carries, and z.
    for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 0, 1)}) {
        LayeredBody body = ball({0, -length, 0}, 2e4, 0.08);
        add_joint(body.base, JointKind::two_axis, Joint::world, 0, Vec3::Zero(), Vec3::UnitX(),
                  Vec3::UnitZ());
        LayeredScene scene = scene_of({body});
        scene.states[0].spin[0] = 0.3 * axis + 5 * Vec3::UnitY();
        scene.states[0].velocity[0] = scene.states[0].spin[0].cross(scene.states[0].position[0]);
        const double quarter = 0.25 * swing_time(body);
        const int steps = static_cast<int>(std::lround(quarter / step));
        for (int i = 0; i < steps; ++i) {
            scene = advance(scene, scene.parts, world_of(GetParam()), step, 1);
            // What the first step turned it comes back, with Bullet by a fifth a step.
            if (i > 20) {
                EXPECT_LT(std::abs(scene.states[0].spin[0].y()), 0.05);
            }
        }
        // A quarter of a swing later it hangs still at angle = speed / omega.
        const double angle = std::asin(
            std::hypot(scene.states[0].position[0].x(), scene.states[0].position[0].z()) / length);
        EXPECT_NEAR(angle, 0.3 * swing_time(body) / (2 * pi), 0.03 * angle);
        EXPECT_LT(scene.states[0].spin[0].norm(), 0.02);
    }
}

TEST_P(EitherSolver, JointsOfTwoFreeBodiesKeepMomentumAndHold)
{
    for (const JointKind kind : {JointKind::ball, JointKind::slider, JointKind::two_axis}) {
        LayeredBody body = two_limbs(-1, 1);
        body.base.hinges.clear();
        add_joint(body.base, kind, 0, 1, {0.45, 0, 0}, Vec3::UnitX(), Vec3::UnitZ());
        LayeredScene scene = scene_of({body});
        scene.states[0].velocity = {{0, 0.3, 0}, {0.2, -0.3, 0.1}};
        scene.states[0].spin = {{0.5, 0, 1}, {0, -1, 0.4}};
        scene = advance(scene, scene.parts, world_of(GetParam(), Vec3::Zero()), step, 1);
        const Vec3 linear = momentum(scene), angular = angular_momentum(scene);
        double off = 0;
        for (int i = 0; i < 200; ++i) {
            scene = advance(scene, scene.parts, world_of(GetParam(), Vec3::Zero()), step, 1);
            const LayeredMoment moment(scene);
            const JointRows rows =
                joint_rows(body.base.joints[0], moment.frames[0][0], moment.frames[0][1]);
            for (const JointRow& row : rows.all()) off = std::max(off, std::abs(row.value));
        }
        EXPECT_LT(off, 2e-3) << "kind " << int(kind);
        EXPECT_LT((momentum(scene) - linear).norm(), 1e-6 * body.base.mass[0]);
        EXPECT_LT((angular_momentum(scene) - angular).norm(), 0.02 * angular.norm())
            << "kind " << int(kind);
    }
}

TEST(Joint, MistakesThrow)
{
    LayeredBody body = two_limbs(-1, 1);
    const auto refused = [&](JointKind kind, std::uint32_t a, std::uint32_t b, const Vec3& axis) {
        EXPECT_THROW(add_joint(body.base, kind, a, b, Vec3::Zero(), axis, Vec3::UnitZ()),
                     std::invalid_argument);
    };
    refused(JointKind::ball, 0, 0, Vec3::UnitX());
    refused(JointKind::ball, 0, 2, Vec3::UnitX());
    refused(JointKind::slider, Joint::world, 0, Vec3::Zero());
    refused(JointKind::two_axis, 0, 1, Vec3(0, 0, 2));  // not square to the second
}

// A joint with the world is part of the drawing: it goes where the body is put, turned as that is,
// and stays there whatever later poses say. The ball hangs from it without weight, and the spring
// has nothing to do.
TEST_P(EitherSolver, AJointWithTheWorldIsWhereTheBodyIsPut)
{
    for (const JointKind kind : {JointKind::ball, JointKind::slider, JointKind::two_axis}) {
        LayeredBody body = pendulum(kind, 0.3);
        body.base.joints[0].stiffness = 100;
        LayeredPart part{.body = std::make_shared<const LayeredBody>(body)};
        part.pose.translate(Vec3(1, 2, 3))
            .rotate(Eigen::AngleAxisd(0.8, Vec3(1, 1, 0).normalized()));
        LayeredScene scene = start({part});
        const Vec3 before = scene.states[0].position[0];
        for (int i = 1; i <= 20; ++i) {
            part.pose.pretranslate(Vec3(0.1, 0, 0));
            scene = advance(scene, {part}, world_of(GetParam(), Vec3::Zero()), 1.0 / 24, 1);
        }
        EXPECT_LT((scene.states[0].position[0] - before).norm(), 1e-9);
        EXPECT_LT(scene.states[0].spin[0].norm(), 1e-9);
    }
}

// A limb that is held goes as it is told; the joint of the other with the world does not.
TEST(Joint, WithTheWorldStaysWhereTheStartHadItWhenOthersAreHeld)
{
    LayeredBody body = make_layered_body(soft_layer({point({0, 0, 0}), point({1, 0, 0})}, true),
                                         BaseKind::rigid, 1000, 0.08);
    add_joint(body.base, JointKind::ball, Joint::world, 1, {1, 0, 0}, Vec3::UnitY());
    LayeredPart part{.body = std::make_shared<const LayeredBody>(body), .held = {{0}}};
    LayeredScene scene = start({part});
    part.pose.translate(Vec3(0, 0.5, 0));
    for (int i = 0; i < 3; ++i) {
        scene = advance(scene, {part}, world_of(RigidBodies::implicit, Vec3::Zero()), 1.0 / 24, 1);
    }
    EXPECT_LT((scene.states[0].position[0] - Vec3(0, 0.5, 0)).norm(), 1e-9);
    EXPECT_LT((scene.states[0].position[1] - Vec3(1, 0, 0)).norm(), 1e-9);
}

}  // namespace physics::joint_test
