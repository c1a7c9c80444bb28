#include "physics/contact.hpp"

#include "geometry/primitive.hpp"
#include "geometry/random.hpp"
#include "physics/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;
using geometry::Transform;

Vec3 somewhere(std::uint64_t i)
{
    const geometry::Random random(5);
    return 4 * Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)) -
           Vec3::Constant(2);
}

Transform some_pose()
{
    Transform pose(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
    pose.pretranslate(Vec3(0.3, -0.2, 0.5));
    return pose;
}

TEST(Contact, GapsAndNormalsAreThoseOfTheShapes)
{
    Collider c;
    c.pose = c.before = some_pose();
    c.thickness = 0.05;
    for (std::uint64_t i = 0; i < 200; ++i) {
        const Vec3 p = somewhere(i), local = some_pose().inverse() * p;
        c.kind = Collider::Kind::plane;
        Touch t = touch(pose_collider(c, 1, 1, 0.1), p);
        EXPECT_NEAR(t.gap, local.y() - 0.05, 1e-12);
        c.kind = Collider::Kind::sphere;
        t = touch(pose_collider(c, 1, 1, 0.1), p);
        EXPECT_NEAR(t.gap, local.norm() - 1.05, 1e-12);
        c.kind = Collider::Kind::box;
        t = touch(pose_collider(c, 1, 1, 0.1), p);
        // Along its normal, the gap leads to the surface.
        const Touch there = touch(pose_collider(c, 1, 1, 0.1), p - t.gap * t.normal);
        EXPECT_NEAR(there.gap, 0, 1e-12);
        EXPECT_NEAR(t.normal.norm(), 1, 1e-12);
        EXPECT_EQ(t.gap + 0.05 < 0, (local.cwiseAbs().array() < 0.5).all());
    }
}

TEST(Contact, ABoxAndItsMeshAreTheSameInside)
{
    Collider box;
    box.kind = Collider::Kind::box;
    Collider mesh;
    mesh.kind = Collider::Kind::mesh;
    mesh.mesh = std::make_shared<const geometry::TriMesh>(geometry::box({1, 1, 1}, {2, 2, 2}));
    const auto posed_box = pose_collider(box, 1, 1, 0.05);
    const auto posed_mesh = pose_collider(mesh, 1, 1, 0.05);
    int inside = 0;
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Vec3 p = 0.4 * somewhere(i);
        const Touch a = touch(posed_box, p), b = touch(posed_mesh, p);
        EXPECT_EQ(a.gap < 0, b.gap < 0);
        if (a.gap >= 0) continue;
        ++inside;
        EXPECT_NEAR(a.gap, b.gap, 1e-6);
    }
    EXPECT_GT(inside, 50);
}

TEST(Contact, TheSurfaceMovesWithItsPose)
{
    // Half way through a quarter turn in a tenth of a second, the point at the rim moves along.
    Collider c;
    c.kind = Collider::Kind::sphere;
    c.pose = Transform(Eigen::AngleAxisd(0.02, Vec3::UnitY()));
    const Touch t = touch(pose_collider(c, 1, 0.1, 0.1), Vec3(1, 0, 0));
    EXPECT_NEAR(t.velocity.z(), -0.2, 1e-3);  // omega x r = 0.2 (0 1 0) x (1 0 0)
    EXPECT_NEAR(t.velocity.x(), 0, 3e-3);
}

// A block with a finely divided surface dropped on a box, and on the mesh of that box.
TEST(Contact, ABlockRestsOnAMeshAsOnABox)
{
    auto cubes = fixtures::box(3, 3, 3, 0.1, {.young = 2e5, .stiffness_damping = 0.02});
    geometry::TriMesh surface = geometry::box({0.3, 0.3, 0.3}, {12, 12, 12});
    for (auto& p : surface.positions) p += geometry::Vec3f::Constant(0.15f);
    const BricksBody body = make_bricks(cubes, {}, &surface);
    Collider box;
    box.kind = Collider::Kind::box;
    box.pose = box.before = Transform(Eigen::Translation3d(0.15, -0.5, 0.15));
    Collider mesh;
    mesh.kind = Collider::Kind::mesh;
    auto shape = geometry::box({1, 1, 1}, {4, 4, 4});
    for (auto& p : shape.positions) p += geometry::Vec3f(0.15f, -0.5f, 0.15f);
    mesh.mesh = std::make_shared<const geometry::TriMesh>(std::move(shape));
    for (const Collider& collider : {box, mesh}) {
        Loads loads;
        loads.forces.push_back({});
        loads.colliders.push_back(collider);
        State state = rest_state(body);
        for (int i = 0; i < 100; ++i) state = advance(body, state, loads, 1.0 / 24);
        double mean = 0, fastest = 0;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            mean += state.x[k].y() / double(state.x.size());
            fastest = std::max(fastest, state.v[k].norm());
        }
        // Its own squash, about rho g H^2 / 2 E = 2 mm at half height, and a tenth of a cube's.
        EXPECT_NEAR(mean, 0.15 - 1.5e-3, 1e-3);
        EXPECT_LT(fastest, 1e-3);
        EXPECT_TRUE(state.report.converged);
    }
}

TEST(Contact, AMovingColliderCarriesWhatRestsOnIt)
{
    // A plate that moves sideways at 0.5 m/s takes the block along by friction.
    const auto cubes = fixtures::box(2, 1, 2, 0.1, {.young = 1e5, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes);
    Collider plate;
    State state = rest_state(body);
    for (int i = 0; i < 48; ++i) {
        Loads loads;
        loads.forces.push_back({});
        plate.friction = 1;
        plate.before = Transform(Eigen::Translation3d(0.5 * i / 24, 0, 0));
        plate.pose = Transform(Eigen::Translation3d(0.5 * (i + 1) / 24, 0, 0));
        loads.colliders.push_back(plate);
        state = advance(body, state, loads, 1.0 / 24);
    }
    for (const Vec3& v : state.v) EXPECT_NEAR(v.x(), 0.5, 0.02);
}

}  // namespace
