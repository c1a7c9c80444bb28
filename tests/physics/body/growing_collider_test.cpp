// Colliders whose size or thickness changes within a frame.

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/collider_contact.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;
using geometry::Transform;

constexpr double frame_time = 1.0 / 24;

Vec3 somewhere(std::uint64_t i)
{
    const geometry::Random random(7);
    return 4 * Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)) -
           Vec3::Constant(2);
}

// One that is as large as `size` at the end of the frame.
Collider grown(Collider::Kind kind, const ColliderSize& size, const ColliderSize& before)
{
    Collider c;
    c.kind = kind;
    c.pose = Transform(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
    c.pose.pretranslate(Vec3(0.3, -0.2, 0.5));
    c.before = c.pose;
    c.radius = size.radius;
    c.half_size = size.half_size;
    c.thickness = size.thickness;
    c.size_before = before;
    return c;
}

// The speed of a surface along its normal is that by which the gap to a fixed place shrinks. All
// gaps are linear in the share of the frame but those over the edges of a box: there the central
// difference has an error of share_sq.
TEST(GrowingCollider, SurfacesMoveAtTheSpeedByWhichTheGapsShrink)
{
    constexpr double step = 1e-4;  // of the frame
    using Kind = Collider::Kind;
    for (const Kind kind : {Kind::plane, Kind::sphere, Kind::box}) {
        const Collider c = grown(kind, {1.1, {0.9, 1.2, 1}, 0.05}, {1, {1, 1, 1}, 0.02});
        for (std::uint64_t i = 0; i < 200; ++i) {
            const Vec3 p = somewhere(i);
            const Touch t = touch(pose_collider(c, 0.3, frame_time, 0.1), p);
            const double earlier = touch(pose_collider(c, 0.3 - step, frame_time, 0.1), p).gap;
            const double later = touch(pose_collider(c, 0.3 + step, frame_time, 0.1), p).gap;
            const double speed = (earlier - later) / (2 * step * frame_time);
            ASSERT_NEAR(t.velocity.dot(t.normal), speed, 1e-6) << i;
        }
        const Touch end = touch(pose_collider(c, 1, frame_time, 0.1), somewhere(0));
        Collider still = c;
        still.size_before.reset();
        const Touch alike = touch(pose_collider(still, 1, frame_time, 0.1), somewhere(0));
        EXPECT_NEAR(end.gap, alike.gap, 1e-12);
        EXPECT_EQ(alike.velocity, Vec3::Zero());
    }
}

TEST(GrowingCollider, WhatWentThroughIsPushedByTheSideThatItCameFrom)
{
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.radius = 0.02;
    ball.size_before = ColliderSize{0.01, ball.half_size, 0};
    const double rate = 0.01 / frame_time;  // m/s
    const Vec3 to(0, -0.015, 0), v(0, -0.05 / frame_time, 0);
    const Touch t = touch(pose_collider(ball, 1, frame_time, 0.05), to, v, frame_time);
    EXPECT_NEAR(t.normal.y(), 1, 1e-9);
    EXPECT_NEAR(t.gap, -0.035, 1e-9);
    EXPECT_NEAR(t.velocity.y(), rate, 1e-9);
}

// Points come from above or below, and the sheet becomes thicker to both sides.
TEST(GrowingCollider, ASheetThickensToBothSides)
{
    Collider sheet;
    sheet.kind = Collider::Kind::mesh;
    sheet.sheet = true;
    sheet.mesh = std::make_shared<const geometry::TriMesh>(geometry::grid(2, 2, 3, 3));
    sheet.thickness = 0.03;
    sheet.size_before = ColliderSize{sheet.radius, sheet.half_size, 0.01};
    const PosedCollider posed = pose_collider(sheet, 0.5, frame_time, 0.1);
    for (const double side : {1.0, -1.0}) {
        const Touch t = touch(posed, Vec3(0.1, side * 0.015, 0), Vec3::Zero(), frame_time);
        EXPECT_NEAR(t.gap, -0.005, 1e-6);
        EXPECT_NEAR(t.normal.y(), side, 1e-6);
        EXPECT_NEAR(t.velocity.y(), side * 0.02 / frame_time, 1e-6);
    }
}

// The top of a box rises at 1 m/s under a block, by its size or by its thickness. With any number
// of steps the block comes to go with it; when the frame of its start was one of the end's size,
// more steps threw it out faster.
TEST(GrowingCollider, ATopThatRisesLiftsABlockAtItsSpeed)
{
    const auto cubes = fixtures::box(2, 1, 2, 0.1, {.young = 1e5, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes);
    for (const bool thickens : {false, true}) {
        for (const int substeps : {1, 4, 16}) {
            Collider box;
            box.kind = Collider::Kind::box;
            box.half_size = {2, 1, 2};
            box.pose = box.before = Transform(Eigen::Translation3d(0, -1, 0));
            State state = rest_state(body);
            double fastest = 0;
            for (int i = 0; i < 24; ++i) {
                Loads loads;
                loads.forces.push_back({});
                const Collider last = box;
                (thickens ? box.thickness : box.half_size.y()) += frame_time;
                box.began_as(last);
                loads.colliders.push_back(box);
                StepOptions options;
                options.substeps = substeps;
                state = advance(body, state, loads, frame_time, options);
                for (const Vec3& v : state.v) fastest = std::max(fastest, v.y());
            }
            EXPECT_LT(fastest, 1.5) << substeps;
            for (const Vec3& v : state.v) EXPECT_NEAR(v.y(), 1, 0.02) << substeps;
        }
    }
}

}  // namespace
