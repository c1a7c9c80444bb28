#include "render/marker.hpp"

#include "geometry/mesh/measure.hpp"
#include "render/carried_force.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::Box;
using geometry::Vec3;

Box unit_box()
{
    Box box;
    box.add(Vec3(-0.5, 0, -0.5));
    box.add(Vec3(0.5, 1, 0.5));
    return box;
}

TEST(Marker, AnArrowRunsFromItsTailToItsTip)
{
    const Vec3 from(1, 2, 3), to(1, 2, 7);
    const auto mesh = render::arrow(from, to, 0.4);
    const Box box = geometry::bounds(mesh);
    EXPECT_NEAR(box.lo.z(), 3, 1e-6);
    EXPECT_NEAR(box.hi.z(), 7, 1e-6);
    EXPECT_NEAR(box.size().x(), 0.4, 1e-5);
    EXPECT_GT(geometry::enclosed_volume(mesh), 0);  // wound outwards
    EXPECT_TRUE(geometry::all_finite(mesh));
    EXPECT_TRUE(render::arrow(from, from, 1).positions.empty());
}

TEST(Marker, PinsAreBallsOfTheRadiusThatIsAskedFor)
{
    physics::Pins pins;
    pins.target = {{1, 2, 3}};
    const auto balls = render::pin_marks(pins, 0.07);
    EXPECT_EQ(balls.radius, 0.07f);
    ASSERT_EQ(balls.centres.size(), 1u);
    EXPECT_EQ(balls.centres[0], geometry::Vec3f(1, 2, 3));
}

TEST(Marker, ForcesPointWhereTheyPush)
{
    physics::Force force;
    force.kind = physics::Force::Kind::point;
    force.force = {0, -10, 0};
    force.position = {0.2, 1, 0};
    const auto point = render::force_arrows(force, unit_box(), 10);
    ASSERT_EQ(point.size(), 1u);
    const Box box = geometry::bounds(point[0]);
    EXPECT_NEAR(box.lo.y(), 1, 1e-6);  // its tip is on the place that is pushed
    // Half of 0.24 of the stage's diagonal, as the force is the weight.
    EXPECT_NEAR(box.size().y(), 0.12 * std::sqrt(3), 1e-6);

    // However weak, it is seen; without limit it is no longer than 0.24 of the diagonal.
    const auto length = [&](double newtons) {
        force.force = {0, -newtons, 0};
        return geometry::bounds(render::force_arrows(force, unit_box(), 10)[0]).size().y();
    };
    EXPECT_NEAR(length(1e-3), 0.06 * std::sqrt(3), 1e-6);
    EXPECT_NEAR(length(1e9), 0.24 * std::sqrt(3), 1e-6);

    force.kind = physics::Force::Kind::wind;
    force.velocity = {3, 0, 0};
    for (const auto& mesh : render::force_arrows(force, unit_box(), 10)) {
        EXPECT_LT(geometry::bounds(mesh).hi.x(), -0.5);  // blows in from outside
    }
    force.velocity = {0, 0, 0};
    EXPECT_TRUE(render::force_arrows(force, unit_box(), 10).empty());
    force.kind = physics::Force::Kind::point;
    force.force = {0, 0, 0};
    EXPECT_TRUE(render::force_arrows(force, unit_box(), 0).empty());
}

// 0.5 sqrt(3) m at 10 N is what half of the greatest length, 0.12 of the diagonal, stands for.
TEST(Marker, ATorqueIsAnArrowAlongItsAxisWithTwoHeads)
{
    physics::Force force;
    force.kind = physics::Force::Kind::torque;
    force.position = {0.2, 1, 0};
    force.torque = {0, 5 * std::sqrt(3), 0};
    const auto arrows = render::force_arrows(force, unit_box(), 10);
    ASSERT_EQ(arrows.size(), 2u);
    const Box whole = geometry::bounds(arrows[1]), second = geometry::bounds(arrows[0]);
    EXPECT_NEAR(whole.lo.y(), 1, 1e-6);
    EXPECT_NEAR(whole.size().y(), 0.12 * std::sqrt(3), 1e-6);
    EXPECT_NEAR(second.lo.y(), 1, 1e-6);
    EXPECT_LT(second.hi.y(), whole.hi.y() - 0.04 * std::sqrt(3));
    EXPECT_GT(second.size().y(), 0.5 * whole.size().y());
    force.torque = {0, -1e-6, 0};
    EXPECT_LT(geometry::bounds(render::force_arrows(force, unit_box(), 10)[1]).lo.y(), 0.9);
}

TEST(Marker, NotesOfForcesSayHowStrongTheyAre)
{
    physics::Force force;
    force.kind = physics::Force::Kind::point;
    force.force = {0, -120, 0};
    force.position = {0.2, 1, 0};
    const auto note = render::force_note(force, unit_box(), 10);
    ASSERT_TRUE(note);
    EXPECT_EQ(note->text, "120 N");
    EXPECT_EQ(note->tip, force.position);
    EXPECT_GT(note->from.y(), note->tip.y());
    EXPECT_DOUBLE_EQ(note->clear, 0.015 * std::sqrt(3));
    force.kind = physics::Force::Kind::wind;
    force.velocity = {3, 4, 0};
    EXPECT_EQ(render::force_note(force, unit_box(), 10)->text, "5 m/s");
    force.kind = physics::Force::Kind::gravity;
    EXPECT_EQ(render::force_note(force, unit_box(), 10)->text, "9.81 m/s^2");
    force.acceleration = {0, 0, 0};
    EXPECT_FALSE(render::force_note(force, unit_box(), 10));
    force.kind = physics::Force::Kind::radial;
    force.outward = -3, force.swirl = {0, 4, 0};
    EXPECT_EQ(render::force_note(force, unit_box(), 10)->text, "5 m/s^2");
    EXPECT_EQ(render::force_arrows(force, unit_box(), 10).size(), 6u);
    force.kind = physics::Force::Kind::torque;
    EXPECT_FALSE(render::force_note(force, unit_box(), 10));
    force.torque = {0, 30, 40};
    EXPECT_EQ(render::force_note(force, unit_box(), 10)->text, "50 N m");
}

// A body that is turned by a right angle about z and moved takes each place with it; what stands
// out of it too.
TEST(Marker, AForceGoesWithTheMaterialThatItActsOn)
{
    const geometry::Cubes cubes = fixtures::box(2, 2, 2, 0.5);
    render::CarriedPoints corners{geometry::corner_positions(cubes), {}};
    geometry::Transform motion = geometry::Transform::Identity();
    motion.linear() << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    motion.translation() = Vec3(3, 0, 0.5);
    for (const Vec3& p : corners.rest) corners.now.push_back(motion * p);
    physics::Force force;
    force.kind = physics::Force::Kind::point;
    force.force = {-10, 0, 0};
    force.torque = {2, 0, 0};
    for (const Vec3& place : {Vec3(0.3, 0.2, 0.6), Vec3(1.1, 0.2, 0.6), Vec3(0, 0, 0)}) {
        for (const double radius : {0.0, 0.3, 2.0}) {
            force.position = place;
            const auto found = render::motion_at(cubes, corners, place, radius, true);
            ASSERT_TRUE(found);
            const physics::Force now = render::carried(force, *found);
            EXPECT_LT((now.position - motion * place).norm(), 1e-12);
            EXPECT_EQ(now.force, force.force);
            const auto by_points = render::motion_at(corners, place, radius);
            EXPECT_TRUE(by_points.isApprox(motion, 1e-12));
            force.follow = true;
            const physics::Force turned = render::carried(force, *found);
            EXPECT_LT((turned.force - Vec3(0, -10, 0)).norm(), 1e-12);
            EXPECT_LT((turned.torque - Vec3(0, 2, 0)).norm(), 1e-12);
            force.follow = false;
        }
    }
    const Vec3 far(9, 0, 0);
    EXPECT_FALSE(render::motion_at(cubes, corners, far, 0.3, true));
    EXPECT_TRUE(render::motion_at(cubes, corners, far, 0.3, false));
}

// Twice as long along x: the place in the middle of a cube goes with its material.
TEST(Marker, AForceGoesWithTheMaterialWithinACube)
{
    const geometry::Cubes cubes = fixtures::box(1, 1, 1, 1);
    render::CarriedPoints corners{geometry::corner_positions(cubes), {}};
    for (const Vec3& p : corners.rest) corners.now.emplace_back(2 * p.x(), p.y(), p.z());
    const Vec3 place = cubes.origin + Vec3(0.25, 0.5, 0.5);
    const auto motion = render::motion_at(cubes, corners, place, 0, false);
    ASSERT_TRUE(motion);
    EXPECT_LT((*motion * place - Vec3(2 * place.x(), place.y(), place.z())).norm(), 1e-12);
    EXPECT_LT((motion->linear() - geometry::Mat3::Identity()).norm(), 1e-12);
}

TEST(Marker, AGhostIsClearAndCastsNoShadow)
{
    const auto mesh = std::make_shared<const geometry::TriMesh>();
    const render::Surface ghost = render::ghost(mesh, 0.2f);
    EXPECT_EQ(ghost.mesh, mesh);
    EXPECT_EQ(ghost.opacity, 0.2f);
    EXPECT_FALSE(ghost.shadow);
    EXPECT_EQ(ghost.kind, render::Surface::Kind::ghost);
}

TEST(Marker, CollidersStandWhereTheirPoseSays)
{
    physics::Collider collider;
    collider.kind = physics::Collider::Kind::sphere;
    collider.radius = 2;
    collider.pose.translation() = Vec3(1, 0, 0);
    const Box ball = geometry::bounds(*render::collider_surface(collider, unit_box()));
    EXPECT_NEAR(ball.lo.x(), -1, 1e-2);
    EXPECT_NEAR(ball.hi.x(), 3, 1e-2);
    collider.kind = physics::Collider::Kind::box;
    collider.half_size = {1, 2, 3};
    const Box box = geometry::bounds(*render::collider_surface(collider, unit_box()));
    EXPECT_LT((box.size() - Vec3(2, 4, 6)).norm(), 1e-6);
    collider.kind = physics::Collider::Kind::mesh;
    EXPECT_EQ(render::collider_surface(collider, unit_box()), nullptr);
}

}  // namespace
