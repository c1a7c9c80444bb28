// Bodies that are told where to be: skeletons that move inside a still body, and figures in a pose.

#include "physics/layered_bodies/figure_pose.hpp"
#include "physics/layered_bodies/inner_motion.hpp"
#include "physics/layered_bodies/inverse_kinematics.hpp"
#include "physics/layers/velocity_at.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace physics::told_figures_test {
namespace {

using namespace layered_fixtures;

constexpr double frame = 1.0 / 24;

// A still body of one segment that turns and moves; drawn there, or put there by its pose.
LayeredPart pusher(const Transform& at, bool drawn)
{
    const Vec3 a(-0.3, 0, 0), b(0.3, 0, 0);
    Skeleton segment{.kind = SkeletonKind::segment, .points = {a, b}};
    if (drawn) segment.points = {at * a, at * b};
    LayeredBody body = make_layered_body(soft_layer({segment}), BaseKind::still, 1, 0.05);
    body.matter.rigid = true;
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(std::move(body));
    if (!drawn) part.pose = at;
    return part;
}

// How fast a ball goes that such a body has pushed along z for half a second.
Vec3 pushed(bool drawn)
{
    LayeredPart struck;
    struck.body = std::make_shared<const LayeredBody>(ball({0.1, 0, 0.25}));
    const auto at = [](int i) {
        Transform t = Transform::Identity();
        t.translate(Vec3(0, 0, 2 * frame * i)).rotate(Eigen::AngleAxisd(0.02 * i, Vec3::UnitY()));
        return t;
    };
    LayeredScene scene = start({pusher(at(0), drawn), struck});
    for (int i = 1; i <= 12; ++i) {
        scene = advance(scene, {pusher(at(i), drawn), struck}, weightless, frame, 2);
        for (const std::string& warning : scene.states[0].report.warnings) ADD_FAILURE() << warning;
    }
    return scene.states[1].velocity[0];
}

}  // namespace

TEST(ToldFigures, SkeletonsKeyedInsideABodyPushAsTheBodyKeyedDoes)
{
    const Vec3 by_points = pushed(true), by_pose = pushed(false);
    EXPECT_GT(by_pose.z(), 1.5);
    // The samples of a body that is drawn anew stand elsewhere on the same surface.
    EXPECT_LT((by_points - by_pose).norm(), 0.01 * by_pose.norm())
        << by_points.transpose() << " | " << by_pose.transpose();
}

TEST(ToldFigures, InnerMotionIsTheRigidMotionAndWhatIsLeft)
{
    Transform by = Transform::Identity();
    by.translate(Vec3(0.1, 0.2, -0.3)).rotate(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()));
    const std::vector<Vec3> triangle{{0, 0, 0}, {1, 0, 0}, {0.2, 0.8, 0.1}};
    for (const std::size_t count : {1u, 2u, 3u}) {
        Skeleton p{.kind = SkeletonKind::polyline,
                   .points = {triangle.begin(), triangle.begin() + static_cast<long>(count)}};
        Skeleton q = p;
        for (Vec3& x : q.points) x = by * x;
        const InnerMotion motion = inner_motion(p, q);
        EXPECT_EQ(motion.rest, 0);
        for (std::size_t i = 0; i < count; ++i) {
            EXPECT_LT((motion.by * p.points[i] - q.points[i]).norm(), 1e-12);
        }
        EXPECT_TRUE(geometry::is_rigid(motion.by));
        // The axes of a stretch do not turn with the points.
        p.stretch(0, 0) = q.stretch(0, 0) = 2;
        const InnerMotion stretched = inner_motion(p, q);
        EXPECT_EQ(stretched.by.linear(), Mat3::Identity());
        EXPECT_EQ(stretched.rest > 1e-3, count > 1);
    }
    const Skeleton p{.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {1, 0, 0}}};
    const Skeleton longer{.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {1.2, 0, 0}}};
    EXPECT_NEAR(inner_motion(p, longer).rest, 0.1, 1e-12);
    Skeleton box{.kind = SkeletonKind::box, .points = {}};
    Skeleton placed = box;
    placed.place = by;
    EXPECT_LT((inner_motion(box, placed).by.matrix() - by.matrix()).norm(), 1e-12);
}

// How fast a ball goes that the end of a still body has pushed along x for half a second at 2 m/s:
// the body moves, or it becomes longer there.
static double pushed_along(SkeletonKind kind, bool grows, int steps)
{
    const auto part = [&](int i) {
        const double way = 2 * frame * i;
        Skeleton s{.kind = kind, .points = {}, .half_size = {0.2, 0.2, 0.2}};
        if (kind == SkeletonKind::segment) {
            s.points = {{grows ? -0.3 : -0.3 + way, 0, 0}, {0.2 + way, 0, 0}};
        } else if (grows) {
            s.half_size.x() += way;
        } else {
            s.place.translate(Vec3(way, 0, 0));
        }
        LayeredBody body = make_layered_body(soft_layer({s}), BaseKind::still, 1, 0.05);
        body.matter.rigid = true;
        LayeredPart p;
        p.body = std::make_shared<const LayeredBody>(std::move(body));
        return p;
    };
    LayeredPart struck;
    LayeredBody clay = ball({0.45, 0, 0});
    clay.matter.restitution = 0;
    struck.body = std::make_shared<const LayeredBody>(clay);
    LayeredScene scene = start({part(0), struck});
    for (int i = 1; i <= 12; ++i) {
        scene = advance(scene, {part(i), struck}, weightless, frame, steps);
        for (const std::string& warning : scene.states[0].report.warnings) ADD_FAILURE() << warning;
        EXPECT_EQ(scene.states[0].position.size(), 1u);
    }
    return scene.states[1].velocity[0].x();
}

// The surface that meets the ball is the same one, at the same speed: what differs is of the order
// of a step, in which forces of frames are linear and those of shapes are not.
TEST(ToldFigures, AKeyedLengthPushesAsABodyThatMoves)
{
    for (const SkeletonKind kind : {SkeletonKind::segment, SkeletonKind::box}) {
        for (const int steps : {2, 32}) {
            const double moved = pushed_along(kind, false, steps),
                         grown = pushed_along(kind, true, steps);
            EXPECT_GT(moved, 1.5);
            EXPECT_NEAR(grown, moved, (steps == 2 ? 0.1 : 0.01) * moved)
                << static_cast<int>(kind) << " " << steps;
        }
    }
}

// Each place of a skeleton goes by its share: a third up a segment that becomes longer at one end
// by 0.3 m goes 0.1 m; a triangle's place by its three shares; the face of a box with its half.
TEST(ToldFigures, PlacesOfASkeletonGoByTheirShares)
{
    Skeleton before{.kind = SkeletonKind::segment, .points = {{0, 0, 0}, {0.9, 0, 0}}};
    Skeleton after = before;
    after.points[1].x() = 1.2;
    EXPECT_LT((way_of(before, before, after, {0.3, 0.2, 0}) - Vec3(0.1, 0, 0)).norm(), 1e-15);
    EXPECT_LT((way_of(before, before, after, {5, 0.2, 0}) - Vec3(0.3, 0, 0)).norm(), 1e-15);
    before = {.kind = SkeletonKind::triangle, .points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
    after = before;
    after.points[2].z() = 0.4;
    EXPECT_LT((way_of(before, before, after, {0.1, 0.5, 1}) - Vec3(0, 0, 0.2)).norm(), 1e-15);
    EXPECT_LT((way_of(before, before, after, {-1, 0.25, 1}) - Vec3(0, 0, 0.1)).norm(), 1e-15);
    before = {.kind = SkeletonKind::box, .points = {}, .half_size = {0.2, 0.1, 0.1}};
    before.place.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
    after = before;
    after.half_size.x() = 0.3;
    EXPECT_LT((way_of(before, before, after, {0.05, 0.4, 0}) - Vec3(0, 0.1, 0)).norm(), 1e-15);
    EXPECT_LT((way_of(before, before, after, {0.3, -0.1, 0}) - Vec3(0, -0.05, 0)).norm(), 1e-15);
}

// An arm of two, bent at both joints: positions by trigonometry.
TEST(ToldFigures, APoseTurnsEachLimbAboutTheOneBefore)
{
    LayeredBody body = two_limbs(-3, 3);
    const double angle = 0.7;
    Transform root = Transform::Identity();
    root.translate(Vec3(0, 1, 0));
    const std::vector<Transform> frames = figure_pose(body.base, root, std::vector{angle}, {});
    const Vec3 elbow(0.45, 1, 0), hand(0.9, 0, 0);
    const Vec3 at = frames[1] * (body.base.frames[1].inverse() * hand);
    EXPECT_LT((at - elbow - 0.45 * Vec3(std::cos(angle), std::sin(angle), 0)).norm(), 1e-12);
    EXPECT_NEAR(hinge_angle(body.base.hinges[0], frames[0], frames[1]), angle, 1e-12);

    // The same by each joint.
    body.base.hinges.clear();
    Joint& joint =
        add_joint(body.base, JointKind::two_axis, 0, 1, {0.45, 0, 0}, Vec3::UnitZ(), Vec3::UnitY());
    const auto hand_at = [&](const JointPose& pose) {
        return Vec3(figure_pose(body.base, root, {}, std::vector{pose})[1] *
                    (body.base.frames[1].inverse() * hand));
    };
    EXPECT_LT((hand_at({.first = angle}) - at).norm(), 1e-12);
    const Vec3 both = elbow + 0.45 * Vec3(std::cos(0.3) * std::cos(angle),
                                          std::cos(0.3) * std::sin(angle), -std::sin(0.3));
    EXPECT_LT((hand_at({.first = angle, .second = 0.3}) - both).norm(), 1e-12);
    joint.kind = JointKind::ball;
    EXPECT_LT((hand_at({.turn = {0.5, 0, angle}}) - at).norm(), 1e-12);  // turned about x first
    joint.kind = JointKind::slider;
    joint.axes_a.col(0) = body.base.frames[0].linear().transpose() * Vec3::UnitY();
    EXPECT_LT((hand_at({.first = 0.2}) - Vec3(0.9, 1.2, 0)).norm(), 1e-12);
}

// Drawn as a still body, whose frames all have the world's origin: the limbs stand the same.
TEST(ToldFigures, AStillFigureIsPosedAsARigidOne)
{
    const LayeredBody rigid = two_limbs(-3, 3);
    Base still;
    still.kind = BaseKind::still;
    still.frames.assign(2, Transform::Identity());
    add_hinge(still, 0, 1, {0.45, 0, 0}, Vec3::UnitZ());
    Transform root = Transform::Identity();
    root.translate(Vec3(1, 2, 3)).rotate(Eigen::AngleAxisd(0.3, Vec3::UnitX()));
    const auto a = figure_pose(rigid.base, root, std::vector{0.7}, {});
    const auto b = figure_pose(still, root, std::vector{0.7}, {});
    for (std::size_t f = 0; f < 2; ++f) {
        const Transform drawn = rigid.base.frames[f].inverse();
        EXPECT_LT((a[f] * drawn * Vec3(0.9, 0.1, 0.2) - b[f] * Vec3(0.9, 0.1, 0.2)).norm(), 1e-12);
    }
    const PoseGoal goal{1, {0.9, 0, 0}, {0.45, 0.45, 0}};
    const SolvedPose reached = inverse_kinematics(still, Transform::Identity(), {&goal, 1});
    EXPECT_LT(reached.miss, 1e-5);
    still.kind = BaseKind::particles;
    EXPECT_THROW(add_hinge(still, 0, 1, Vec3::Zero(), Vec3::UnitZ()), std::invalid_argument);
}

// What the pose tells is what the rows of a joint call in place.
TEST(ToldFigures, APoseHoldsTheRowsOfItsJoints)
{
    for (const JointKind kind : {JointKind::ball, JointKind::slider, JointKind::two_axis}) {
        LayeredBody body = two_limbs(-3, 3);
        body.base.hinges.clear();
        add_joint(body.base, kind, 0, 1, {0.45, 0, 0}, Vec3::UnitX(), Vec3::UnitY());
        const JointPose pose{.turn = {0.4, -0.3, 0.2}, .first = 0.1, .second = 0.6};
        const auto frames = figure_pose(body.base, Transform::Identity(), {}, std::vector{pose});
        const JointRows rows = joint_rows(body.base.joints[0], frames[0], frames[1]);
        for (const JointRow& row : rows.all()) {
            EXPECT_NEAR(row.value, 0, 1e-12) << "kind " << int(kind);
        }
    }
}

TEST(ToldFigures, FramesThatNothingJoinsAndLoopsAreRefused)
{
    LayeredBody body = two_limbs(-3, 3);
    add_joint(body.base, JointKind::ball, 0, 1, {0.45, 0, 0}, Vec3::UnitX());
    EXPECT_THROW(figure_pose(body.base, Transform::Identity(), {}, {}), std::invalid_argument);
    body.base.hinges.clear();
    body.base.joints.clear();
    EXPECT_THROW(figure_pose(body.base, Transform::Identity(), {}, {}), std::invalid_argument);
}

}  // namespace physics::told_figures_test
