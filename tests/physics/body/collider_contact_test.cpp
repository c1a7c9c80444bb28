#include "geometry/mesh/mesh.hpp"
#include "physics/body/collider_contact.hpp"

#include "geometry/base/random.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
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

TEST(ColliderContact, GapsAndNormalsAreThoseOfTheShapes)
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

TEST(ColliderContact, ABoxAndItsMeshAreTheSameInside)
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

// Points that went through a plate of 2 cm, or past its middle, from above and from below.
TEST(ColliderContact, APointThatTunneledThroughAThinWallTouchesTheSideItCameFrom)
{
    std::vector<Collider> plates(2);
    plates[0].kind = Collider::Kind::box;
    plates[0].half_size = Vec3(1, 0.01, 1);
    plates[0].pose = plates[0].before = some_pose();
    plates[1] = plates[0];
    plates[1].kind = Collider::Kind::mesh;
    geometry::TriMesh mesh = geometry::box({2, 0.02, 2}, {4, 1, 4});
    for (auto& p : mesh.positions) p = (some_pose() * p.cast<double>()).cast<float>();
    plates[1].mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
    const geometry::Random random(8);
    for (Collider& plate : plates) {
        for (const double thickness : {0.0, 0.003}) {
            plate.thickness = thickness;
            const PosedCollider posed = pose_collider(plate, 1, 1, 0.05);
            for (std::uint64_t i = 0; i < 400; ++i) {
                const double side = i % 2 == 0 ? 1 : -1, dt = 0.005;
                const Vec3 from(random.unit(5 * i) - 0.5,
                                side * (0.008 + 0.05 * random.unit(5 * i + 1)),
                                random.unit(5 * i + 2) - 0.5);
                const Vec3 way(0.05 * random.unit(5 * i + 3), -side * 0.1 * random.unit(5 * i + 4),
                               0.02);
                const Vec3 to = from + way;
                const Touch t = touch(posed, some_pose() * to, some_pose().linear() * way / dt, dt);
                const double gap = side * to.y() - 0.01 - thickness;
                if (gap < 0) {
                    ASSERT_NEAR(t.gap, gap, 1e-6) << i;
                    const Vec3 up = some_pose().linear() * Vec3(0, side, 0);
                    ASSERT_NEAR((t.normal - up).norm(), 0, 1e-6) << i;
                } else {
                    ASSERT_FALSE(t.gap < 0) << i;
                }
            }
        }
    }
}

TEST(ColliderContact, APointThatTunneledThroughASphereTouchesWhereItEntered)
{
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.radius = 0.01;
    const PosedCollider posed = pose_collider(ball, 1, 1, 0.05);
    const Vec3 to(0.006, -0.03, 0), v(0, -10, 0);  // it came from 2 cm above
    const Touch t = touch(posed, to, v, 0.005);
    EXPECT_NEAR((t.normal - Vec3(0.6, 0.8, 0)).norm(), 0, 1e-12);
    EXPECT_NEAR(t.gap, -0.8 * 0.038, 1e-12);
    EXPECT_GT(touch(posed, Vec3(0.011, -0.03, 0), v, 0.005).gap, 0) << "it went past";
    EXPECT_GT(touch(posed, to, -v, 0.005).gap, 0) << "it has not been there yet";
    EXPECT_GT(touch(posed, Vec3(0, 0.02, 0), v, 0.005).gap, 0) << "it is on its way";
    // Still inside, by the side that it came in by: the nearest place of the surface is as good.
    const Vec3 within(0.002, 0.009, 0);
    const Touch grazed = touch(posed, within, Vec3(2, 0.4, 0), 0.005);
    EXPECT_NEAR((grazed.normal - within.normalized()).norm(), 0, 1e-12);
    EXPECT_NEAR(grazed.gap, within.norm() - 0.01, 1e-12);
}

TEST(ColliderContact, APointThatPassesOverTheEdgeOfABoxTouchesNothing)
{
    Collider box;
    box.kind = Collider::Kind::box;
    box.half_size = Vec3(0.1, 0.1, 0.1);
    const PosedCollider posed = pose_collider(box, 1, 1, 0.05);
    const double dt = 0.01;
    const std::vector<std::array<Vec3, 2>> ways = {
        {Vec3(0.07, 0.17, 0), Vec3(0.17, 0.07, 0)},     // outside the edge at x = y = 0.1
        {Vec3(0.03, 0.13, 0), Vec3(0.13, 0.03, 0)},     // through that edge
        {Vec3(0.101, 0.12, 0), Vec3(0.102, -0.15, 0)},  // past the side
        {Vec3(0.095, 0.05, 0), Vec3(0.04, 0.13, 0)}};   // from within, out by the top
    for (const auto& [from, to] : ways) {
        EXPECT_GT(touch(posed, to, (to - from) / dt, dt).gap, 0) << to.transpose();
    }
}

// The wall comes, and the point does not move.
TEST(ColliderContact, AThinWallThatSweepsPastAPointTakesItAlong)
{
    Collider plate;
    plate.kind = Collider::Kind::box;
    plate.half_size = Vec3(1, 0.01, 1);
    plate.pose = Transform(Eigen::Translation3d(0, 0.5, 0));  // 12 m/s
    const PosedCollider posed = pose_collider(plate, 0.5, 1.0 / 24, 0.05);
    const double dt = 1.0 / 24 / 8;
    const Touch t = touch(posed, Vec3(0, 0.22, 0), Vec3::Zero(), dt);
    EXPECT_NEAR(t.normal.y(), 1, 1e-12);
    EXPECT_NEAR(t.gap, -0.04, 1e-12);
    EXPECT_NEAR(t.velocity.y(), 12, 1e-9);
}

TEST(ColliderContact, TheSurfaceMovesWithItsPose)
{
    // Half way through a quarter turn in a tenth of a second, the point at the rim moves along.
    Collider c;
    c.kind = Collider::Kind::sphere;
    c.pose = Transform(Eigen::AngleAxisd(0.02, Vec3::UnitY()));
    const Touch t = touch(pose_collider(c, 1, 0.1, 0.1), Vec3(1, 0, 0));
    EXPECT_NEAR(t.velocity.z(), -0.2, 1e-3);  // omega x r = 0.2 (0 1 0) x (1 0 0)
    EXPECT_NEAR(t.velocity.x(), 0, 3e-3);
}

// A drum that turns in itself by half a radian a frame: nowhere within the frame does its surface
// come out. A chord would, at its end, by 3 m/s.
TEST(ColliderContact, WhatTurnsInItselfDoesNotComeOut)
{
    constexpr double dt = 1.0 / 24;
    const Transform turn(Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.pose = turn;
    Collider drum;
    drum.kind = Collider::Kind::mesh;
    geometry::TriMesh mesh = geometry::icosphere(1, 4);
    drum.mesh_before = std::make_shared<const geometry::TriMesh>(mesh);
    for (auto& p : mesh.positions) p = (turn * p.cast<double>()).cast<float>();
    drum.mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
    for (const double share : {0.25, 0.5, 1.0}) {
        for (const Collider& c : {ball, drum}) {
            // Of the mesh, what its faces lean from its normals there.
            const double out = c.kind == Collider::Kind::mesh ? 0.5 : 1e-9;
            const Touch t = touch(pose_collider(c, share, dt, 0.1), Vec3(0, 0.99, 0));
            EXPECT_NEAR(t.velocity.dot(t.normal), 0, out) << share;
            EXPECT_NEAR(t.velocity.x(), -0.99 * 0.5 / dt, 0.15) << share;
        }
    }
}

// A place on a table that turns by 0.3 rad and slides within a frame: from where it was at the
// start of a step it is carried to where the table takes it, whatever place is asked at the end.
TEST(ColliderContact, WhatATurningTableCarriesGoesAlongItsArc)
{
    constexpr double frame = 1.0 / 24;
    Collider table;
    table.kind = Collider::Kind::box;
    table.half_size = Vec3(2, 0.5, 2);
    table.pose =
        Transform(Eigen::Translation3d(0.1, 0, 0.05) * Eigen::AngleAxisd(0.3, Vec3::UnitY()));
    const Vec3 from(0.8, 0.499, 0.3), to = from + frame * Vec3(1, -0.02, -4);
    const PosedCollider posed = pose_collider(table, 1, frame, 0.1);
    const Touch t = touch(posed, to);
    const Vec3 mean = carrying(posed, t, to, (to - from) / frame, frame);
    EXPECT_LT((from + frame * mean - table.pose * from).norm(), 1e-12);
    EXPECT_GT((from + frame * t.velocity - table.pose * from).norm(), 0.03);
}

// The same of a mesh, in the second half of a frame: its vertices go along straight lines.
TEST(ColliderContact, WhatATurningMeshCarriesGoesAsItsVerticesDo)
{
    constexpr double frame = 1.0 / 24;
    const Transform turn(Eigen::Translation3d(0.1, 0, 0.05) *
                         Eigen::AngleAxisd(0.3, Vec3::UnitY()));
    Collider table;
    table.kind = Collider::Kind::mesh;
    geometry::TriMesh mesh = geometry::box({4, 1, 4}, {2, 1, 2});
    table.mesh_before = std::make_shared<const geometry::TriMesh>(mesh);
    for (auto& p : mesh.positions) p = (turn * p.cast<double>()).cast<float>();
    table.mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
    const Vec3 rest(0.8, 0.499, 0.3), from = (rest + turn * rest) / 2;
    const double dt = frame / 2;
    const Vec3 to = from + dt * Vec3(1, 0, -4);
    const PosedCollider posed = pose_collider(table, 1, frame, 0.1);
    const Touch t = touch(posed, to);
    const Vec3 mean = carrying(posed, t, to, (to - from) / dt, dt);
    EXPECT_LT((from + dt * mean - turn * rest).norm(), 1e-5);
    EXPECT_GT((from + dt * t.velocity - turn * rest).norm(), 0.005);
}

// A box of jelly that rides on a disc at 90 degrees a second, 0.8 m from its axis, one step a
// frame. It leans out by some millimetres: the weight of a metre a second squared.
TEST(ColliderContact, WhatRidesOnATurningDiscKeepsItsDistance)
{
    auto cubes = fixtures::box(2, 2, 2, 0.1, {.young = 2e5, .stiffness_damping = 0.02});
    cubes.origin = Vec3(0.7, 0.5, -0.1);
    const BricksBody body = make_bricks(cubes);
    const double a_frame = double(EIGEN_PI) / 2 / 24;
    const auto turned = [](double angle) {
        return Transform(Eigen::AngleAxisd(angle, Vec3::UnitY()));
    };
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    Collider& disc = loads.colliders.back();
    disc.kind = Collider::Kind::box;
    disc.half_size = Vec3(2, 0.5, 2);
    disc.friction = 1;
    State state = rest_state(body);
    const Vec3 spin(0, 24 * a_frame, 0);
    for (std::size_t k = 0; k < state.x.size(); ++k) state.v[k] = spin.cross(Vec3(state.x[k]));
    for (int i = 0; i < 48; ++i) {
        disc.before = turned(a_frame * i);
        disc.pose = turned(a_frame * (i + 1));
        state = advance(body, std::move(state), loads, 1.0 / 24);
    }
    Vec3 centre = Vec3::Zero();
    for (const Vec3& x : state.x) centre += x / double(state.x.size());
    EXPECT_NEAR(std::hypot(centre.x(), centre.z()), 0.8, 0.01);
    EXPECT_NEAR(std::abs(std::atan2(centre.z(), centre.x())), double(EIGEN_PI), 0.1);
}

// A block with a finely divided surface dropped on a box, and on the mesh of that box.
TEST(ColliderContact, ABlockRestsOnAMeshAsOnABox)
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

// A block thrown at 8 m/s at a plate of 2 cm, a box or a mesh: it goes 4 or 33 cm in a substep.
TEST(ColliderContact, NoMethodLetsABlockThroughAThinPlate)
{
    const auto cubes = fixtures::box(3, 3, 3, 0.1, {.young = 2e5, .stiffness_damping = 0.005});
    Collider box;
    box.kind = Collider::Kind::box;
    box.half_size = Vec3(1, 0.01, 1);
    box.pose = box.before = Transform(Eigen::Translation3d(0.15, -0.3, 0.15));
    Collider mesh;
    mesh.kind = Collider::Kind::mesh;
    auto shape = geometry::box({2, 0.02, 2}, {4, 1, 4});
    for (auto& p : shape.positions) p += geometry::Vec3f(0.15f, -0.3f, 0.15f);
    mesh.mesh = std::make_shared<const geometry::TriMesh>(std::move(shape));
    const BricksBody bricks = make_bricks(cubes);
    const SpringsBody springs = make_springs(cubes);
    const LatticeBody lattice = make_lattice(cubes);
    // Those within touch nothing.
    const auto outside = fixtures::corners_where(
        cubes, [](const auto& c) { return (c.array() == 0).any() || (c.array() == 3).any(); });
    ASSERT_EQ(outside.size(), 56u);
    for (const Collider& plate : {box, mesh}) {
        Loads loads;
        loads.forces.push_back({});
        loads.colliders.push_back(plate);
        const auto lowest_of = [&](State state, const auto& body, int substeps) {
            for (Vec3& v : state.v) v.y() = -8;
            double lowest = 0;
            for (int i = 0; i < 24; ++i) {
                state = advance(body, state, loads, 1.0 / 24, StepOptions{.substeps = substeps});
                for (const auto k : outside) lowest = std::min(lowest, state.x[k].y());
            }
            return lowest;
        };
        for (const int substeps : {1, 8}) {
            EXPECT_GT(lowest_of(rest_state(bricks), bricks, substeps), -0.3) << substeps;
            EXPECT_GT(lowest_of(rest_state(springs), springs, substeps), -0.3) << substeps;
            EXPECT_GT(lowest_of(rest_state(lattice), lattice, substeps), -0.3) << substeps;
        }
    }
}

TEST(ColliderContact, AMovingColliderCarriesWhatRestsOnIt)
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

// One that is as large as `size` at the end of the frame.
Collider growing_collider(Collider::Kind kind, const ColliderSize& size, const ColliderSize& before)
{
    Collider c;
    c.kind = kind;
    c.pose = c.before = some_pose();
    c.radius = size.radius;
    c.half_size = size.half_size;
    c.thickness = size.thickness;
    c.size_before = before;
    return c;
}

// The speed of a surface along its normal is that by which the gap to a fixed place shrinks. All
// gaps are linear in the share of the frame but those over the edges of a box, where the error of
// the central difference is of the order of step^2.
TEST(ColliderContact, AGrowingSurfaceMovesAtTheSpeedByWhichGapsShrink)
{
    constexpr double dt = 1.0 / 24;
    constexpr double step = 1e-4;  // of the frame
    using Kind = Collider::Kind;
    for (const Kind kind : {Kind::plane, Kind::sphere, Kind::box}) {
        const Collider c = growing_collider(kind, {1.1, {0.9, 1.2, 1}, 0.05}, {1, {1, 1, 1}, 0.02});
        for (std::uint64_t i = 0; i < 200; ++i) {
            const Vec3 p = somewhere(i);
            const Touch t = touch(pose_collider(c, 0.3, dt, 0.1), p);
            const double earlier = touch(pose_collider(c, 0.3 - step, dt, 0.1), p).gap;
            const double later = touch(pose_collider(c, 0.3 + step, dt, 0.1), p).gap;
            const double speed = (earlier - later) / (2 * step * dt);
            ASSERT_NEAR(t.velocity.dot(t.normal), speed, 1e-6) << i;
        }
        const Touch end = touch(pose_collider(c, 1, dt, 0.1), somewhere(0));
        Collider still = c;
        still.size_before.reset();
        const Touch alike = touch(pose_collider(still, 1, dt, 0.1), somewhere(0));
        EXPECT_NEAR(end.gap, alike.gap, 1e-12);
        EXPECT_EQ(alike.velocity, Vec3::Zero());
    }
}

TEST(ColliderContact, AGrowingBallPushesByTheSideThatAPointCameFrom)
{
    constexpr double dt = 1.0 / 24;
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.radius = 0.02;
    ball.size_before = ColliderSize{0.01, ball.half_size, 0};
    const double rate = 0.01 / dt;  // m/s
    const Vec3 to(0, -0.015, 0), v(0, -0.05 / dt, 0);
    const Touch t = touch(pose_collider(ball, 1, dt, 0.05), to, v, dt);
    EXPECT_NEAR(t.normal.y(), 1, 1e-9);
    EXPECT_NEAR(t.gap, -0.035, 1e-9);
    EXPECT_NEAR(t.velocity.y(), rate, 1e-9);
}

// Points come from above or below, and the sheet becomes thicker to both sides.
TEST(ColliderContact, ASheetThickensToBothSides)
{
    constexpr double dt = 1.0 / 24;
    Collider sheet;
    sheet.kind = Collider::Kind::mesh;
    sheet.sheet = true;
    sheet.mesh = std::make_shared<const geometry::TriMesh>(geometry::grid(2, 2, 3, 3));
    sheet.thickness = 0.03;
    sheet.size_before = ColliderSize{sheet.radius, sheet.half_size, 0.01};
    const PosedCollider posed = pose_collider(sheet, 0.5, dt, 0.1);
    for (const double side : {1.0, -1.0}) {
        const Touch t = touch(posed, Vec3(0.1, side * 0.015, 0), Vec3::Zero(), dt);
        EXPECT_NEAR(t.gap, -0.005, 1e-6);
        EXPECT_NEAR(t.normal.y(), side, 1e-6);
        EXPECT_NEAR(t.velocity.y(), side * 0.02 / dt, 1e-6);
    }
}

// The top of a box rises at 1 m/s under a block, by its size or by its thickness. With any number
// of steps the block comes to go with it. A box that has its last size from the first step of a
// frame on throws it out, and the more steps, the faster.
TEST(ColliderContact, ATopThatRisesByGrowingLiftsABlockAtItsSpeed)
{
    constexpr double dt = 1.0 / 24;
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
                (thickens ? box.thickness : box.half_size.y()) += dt;
                box.began_as(last);
                loads.colliders.push_back(box);
                StepOptions options;
                options.substeps = substeps;
                state = advance(body, state, loads, dt, options);
                for (const Vec3& v : state.v) fastest = std::max(fastest, v.y());
            }
            EXPECT_LT(fastest, 1.5) << substeps;
            for (const Vec3& v : state.v) EXPECT_NEAR(v.y(), 1, 0.02) << substeps;
        }
    }
}

Collider plane_at(double height)
{
    Collider plane;
    plane.pose.translation().y() = plane.before.translation().y() = height;
    return plane;
}

std::vector<std::string> buried(const geometry::Cubes& cubes, const Pins& pins,
                                std::span<const Collider> colliders)
{
    const std::vector models{std::make_shared<const geometry::Cubes>(cubes)};
    return physics::buried(models, pins, colliders);
}

TEST(ColliderContact, WarnsOfABodyThatStartsMoreThanACubeInsideACollider)
{
    const geometry::Cubes cubes = fixtures::box(4, 4, 4, 0.1);
    const double lowest = geometry::corner_positions(cubes)[0].y();
    const std::vector<Collider> touching{plane_at(lowest + 0.09)};
    EXPECT_TRUE(buried(cubes, {}, touching).empty());
    const std::vector<Collider> two{plane_at(lowest - 1), plane_at(lowest + 0.25)};
    const auto said = buried(cubes, {}, two);
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find("up to 0.25 m inside collider 2 of 2"), std::string::npos) << said[0];
}

TEST(ColliderContact, DoesNotWarnOfPinnedCornersInsideACollider)
{
    const geometry::Cubes cubes = fixtures::box(4, 4, 4, 0.1);
    const auto corners = geometry::corner_positions(cubes);
    Pins pins;
    for (std::uint32_t c = 0; c < corners.size(); ++c) {
        if (corners[c].y() > corners[0].y() + 0.15) continue;
        pins.corner.push_back(c);
        pins.target.push_back(corners[c]);
    }
    const std::vector<Collider> floor{plane_at(corners[0].y() + 0.25)};
    EXPECT_TRUE(buried(cubes, pins, floor).empty());
    pins.corner.pop_back(), pins.target.pop_back();
    EXPECT_EQ(buried(cubes, pins, floor).size(), 1u);
}

TEST(ColliderContact, DoesNotWarnOfCubesWhoseSurfaceIsClear)
{
    // Cubes at a slope reach a cube into it, their surface stays outside.
    const std::vector models{std::make_shared<const geometry::Cubes>(fixtures::box(4, 4, 4, 0.1))};
    const double lowest = models[0]->corner_position(0).y();
    const std::vector<Collider> slope{plane_at(lowest + 0.15)};
    geometry::TriMesh ball = geometry::icosphere(0.2, 2);
    for (auto& p : ball.positions) p.y() += float(lowest) + 0.3f;
    const auto with = [&](const geometry::TriMesh& mesh) {
        const std::vector surfaces{std::make_shared<const geometry::TriMesh>(mesh)};
        return physics::buried(models, {}, slope, surfaces);
    };
    EXPECT_EQ(physics::buried(models, {}, slope).size(), 1u);
    for (auto& p : ball.positions) p.y() += 0.06f;  // from 0.05 m deep to clear
    EXPECT_TRUE(with(ball).empty());
    for (auto& p : ball.positions) p.y() -= 0.2f;
    EXPECT_EQ(with(ball).size(), 1u);
}

TEST(ColliderContact, WarnsOfABodyThatStartsInsideAMesh)
{
    const geometry::Cubes cubes = fixtures::box(4, 4, 4, 0.1);
    Collider stone;
    stone.kind = Collider::Kind::mesh;
    auto ball = geometry::icosphere(0.5, 3);
    for (auto& p : ball.positions) p += cubes.corner_position(0).cast<float>();
    stone.mesh = std::make_shared<const geometry::TriMesh>(ball);
    EXPECT_EQ(buried(cubes, {}, std::vector{stone}).size(), 1u);
    for (auto& p : ball.positions) p.x() -= 0.55f;
    stone.mesh = std::make_shared<const geometry::TriMesh>(ball);
    EXPECT_TRUE(buried(cubes, {}, std::vector{stone}).empty());
}

}  // namespace
