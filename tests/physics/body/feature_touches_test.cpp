#include "geometry/mesh/mesh.hpp"
#include "physics/body/collider_features.hpp"

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

// A cube of 0.3 m of 27 cubes, whose flat face meets what is narrower than a cube.

namespace physics {
namespace {

constexpr double h = 0.1;      // m, of a cube
constexpr double deep = 0.02;  // cubes, at rest

geometry::Cubes block()
{
    return fixtures::box(3, 3, 3, h, {.young = 1e8, .stiffness_damping = 1e-4});
}

BricksBody rigid_block()
{
    return make_bricks(block(), {.rigid = {1}});
}

// A box whose top is at height 0, under `x` and the middle of the block in z.
Collider box_below(const Vec3& size, double x = 0.15)
{
    Collider out;
    out.kind = Collider::Kind::box;
    out.half_size = size / 2;
    out.pose = out.before = geometry::Transform(Eigen::Translation3d(x, -size.y() / 2, 0.15));
    return out;
}

Collider mesh_of(geometry::TriMesh mesh, bool sheet = false)
{
    Collider out;
    out.kind = Collider::Kind::mesh;
    out.mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
    out.sheet = sheet;
    return out;
}

struct Fall {
    double height = 0.05, speed = 0;  // m, m/s
    int frames = 48;
    StepOptions step = {.substeps = 0};
};
State fallen(const auto& body, const Collider& on, const Fall& how = {})
{
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        state.x[k].y() += how.height;
        state.v[k] = Vec3(0, -how.speed, 0);
    }
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back(on);
    for (int frame = 0; frame < how.frames; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, how.step);
    }
    EXPECT_TRUE(fixtures::finite(state));
    return state;
}

double lowest(const State& state)
{
    double out = state.x[0].y();
    for (const Vec3& x : state.x) out = std::min(out, x.y());
    return out;
}
double middle(const State& state)
{
    double out = 0;
    for (const Vec3& x : state.x) out += x.y() / static_cast<double>(state.x.size());
    return out;
}

TEST(FeatureTouches, AFlatFaceRestsOnARailNarrowerThanACube)
{
    for (const double width : {0.2, 0.4, 0.6}) {  // cubes
        const Collider rail = box_below(Vec3(width * h, 0.1, 2));
        const auto rests = [&](const State& state, const char* what) {
            EXPECT_NEAR(middle(state), 0.15, deep * h) << what << " " << width;
            EXPECT_NEAR(lowest(state), 0, deep * h) << what << " " << width;
        };
        rests(fallen(rigid_block(), rail), "rigid");
        rests(fallen(make_bricks(block()), rail), "elastic");
        rests(fallen(make_springs(block()), rail), "springs");
    }
}

TEST(FeatureTouches, ABlockBalancesOnAPostUnderItsMiddleAndTipsBesideIt)
{
    const Vec3 post(0.04, 0.5, 0.04);
    const State on = fallen(rigid_block(), box_below(post));
    EXPECT_NEAR(lowest(on), 0, deep * h);
    EXPECT_NEAR(middle(on), 0.15, deep * h);
    const State beside = fallen(rigid_block(), box_below(post, 0.2));
    EXPECT_LT(lowest(beside), -0.1);
}

TEST(FeatureTouches, ABlockRestsOnBladesAndOnASheetsRim)
{
    // Three-sided prisms with an edge up, a bit beside the middle of the block on both sides.
    geometry::TriMesh blades;
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (const float x : {0.12f, 0.18f}) {
        const auto k = static_cast<std::uint32_t>(blades.positions.size());
        for (const float z : {-0.5f, 0.8f}) {
            blades.positions.push_back({x, 0, z});
            blades.positions.push_back({x - 0.02f, -0.2f, z});
            blades.positions.push_back({x + 0.02f, -0.2f, z});
        }
        for (const geometry::Triangle& t : {geometry::Triangle{0, 2, 1},
                                            {3, 4, 5},
                                            {0, 1, 4},
                                            {0, 4, 3},
                                            {1, 2, 5},
                                            {1, 5, 4},
                                            {2, 0, 3},
                                            {2, 3, 5}}) {
            topology->triangles.push_back({t[0] + k, t[1] + k, t[2] + k});
        }
    }
    blades.topology = topology;
    const State on_blades = fallen(rigid_block(), mesh_of(blades));
    EXPECT_NEAR(lowest(on_blades), 0, deep * h);
    EXPECT_NEAR(middle(on_blades), 0.15, deep * h);

    geometry::TriMesh rims;
    auto two = std::make_shared<geometry::MeshTopology>();
    for (const float x : {0.12f, 0.18f}) {
        const auto k = static_cast<std::uint32_t>(rims.positions.size());
        for (const float z : {-0.5f, 0.8f}) {
            rims.positions.push_back({x, 0, z});
            rims.positions.push_back({x, -0.5f, z});
        }
        two->triangles.push_back({k, k + 1, k + 2});
        two->triangles.push_back({k + 2, k + 1, k + 3});
    }
    rims.topology = two;
    const State on_rims = fallen(make_bricks(block()), mesh_of(rims, true));
    EXPECT_NEAR(lowest(on_rims), 0, deep * h);
    EXPECT_NEAR(middle(on_rims), 0.15, deep * h);
}

TEST(FeatureTouches, ABlockRestsOnBallsAndRodsThinnerThanACube)
{
    // A ball of a twentieth of the block under its middle holds it for a while.
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.radius = 0.03;
    ball.pose = ball.before = geometry::Transform(Eigen::Translation3d(0.15, -0.03, 0.15));
    EXPECT_NEAR(lowest(fallen(rigid_block(), ball, {.frames = 8})), 0, deep * h);

    // Two round rods of 24 sides, whose faces turn by 15 degrees at each edge.
    geometry::TriMesh rods;
    auto topology = std::make_shared<geometry::MeshTopology>();
    constexpr std::uint32_t sides = 24;
    for (const double x : {0.12, 0.18}) {
        const auto k = static_cast<std::uint32_t>(rods.positions.size());
        for (std::uint32_t i = 0; i < sides; ++i) {
            const double angle = 2 * M_PI * i / sides, r = 0.02;
            for (const double z : {-0.5, 0.8}) {
                rods.positions.push_back(
                    Vec3(x + r * std::sin(angle), r * (std::cos(angle) - 1), z).cast<float>());
            }
        }
        for (std::uint32_t i = 0; i < sides; ++i) {
            const auto a = k + 2 * i, b = k + 2 * ((i + 1) % sides);
            topology->triangles.push_back({a, a + 1, b});
            topology->triangles.push_back({b, a + 1, b + 1});
            if (i > 1) {
                topology->triangles.push_back({k, k + 2 * (i - 1), k + 2 * i});
                topology->triangles.push_back({k + 1, k + 2 * i + 1, k + 2 * (i - 1) + 1});
            }
        }
    }
    rods.topology = topology;
    const State on_rods = fallen(rigid_block(), mesh_of(rods));
    EXPECT_NEAR(lowest(on_rods), 0, deep * h);
}

TEST(FeatureTouches, CoarseCubesMeetWhatIsThinnerThanThemBesideABodyOfFinerOnes)
{
    const geometry::Cubes coarse = block();
    geometry::Cubes fine = fixtures::box(3, 3, 3, 0.2 * h, {.young = 1e8});
    fine.origin = Vec3(3, 0, 0);
    const std::vector<BodyModel> both = {{&coarse}, {&fine}};
    const BricksBody body = make_bricks(BodyModels(both), {.rigid = {1, 1}});
    Collider ball;  // larger than a cube of the fine ones
    ball.kind = Collider::Kind::sphere;
    ball.radius = 0.03;
    ball.pose = ball.before = geometry::Transform(Eigen::Translation3d(0.15, -0.03, 0.15));
    State state = fallen(body, ball, {.frames = 8});
    state.x.resize(coarse.corner_count());
    EXPECT_NEAR(lowest(state), 0, deep * h);
}

TEST(FeatureTouches, WhatRestsWithinAWideFaceFeelsNoEdges)
{
    // The same bytes whether the edges of the box are a metre or a hundred away.
    const auto far = fallen(make_bricks(block()), box_below(Vec3(200, 1, 200)));
    const auto near = fallen(make_bricks(block()), box_below(Vec3(2, 1, 2)));
    ASSERT_EQ(far.x.size(), near.x.size());
    for (std::size_t k = 0; k < far.x.size(); ++k)
        EXPECT_NEAR((far.x[k] - near.x[k]).norm(), 0, 1e-12);
    EXPECT_EQ(far.holds.size(), near.holds.size());
}

TEST(FeatureTouches, AnOverhangingBlockRestsAsDeepAsOneWithin)
{
    // A third of the block lies beyond the edge of the table.
    for (const auto& body : {rigid_block(), make_bricks(block())}) {
        const State state = fallen(body, box_below(Vec3(1, 1, 1), -0.3));
        EXPECT_NEAR(lowest(state), 0, deep * h);
        EXPECT_NEAR(middle(state), 0.15, deep * h);
    }
}

TEST(FeatureTouches, ABlockLeavesARailWithTheShareOfItsSpeedThatItStates)
{
    for (const double bounce : {0.0, 0.5}) {
        for (const double speed : {2.0, 10.0}) {
            Collider rail = box_below(Vec3(0.04, 0.1, 2));
            rail.bounce = bounce;
            State state = rest_state(rigid_block());
            const BricksBody body = rigid_block();
            for (std::size_t k = 0; k < state.x.size(); ++k) {
                state.x[k].y() += 0.3;
                state.v[k] = Vec3(0, -speed, 0);
            }
            Loads loads;

            loads.colliders.push_back(rail);
            for (int frame = 0; frame < 8; ++frame) {
                state = advance(body, state, loads, 1.0 / 24);
            }
            Vec3 mean = Vec3::Zero();
            for (const Vec3& v : state.v) mean += v / double(state.v.size());
            EXPECT_NEAR(mean.y(), bounce * speed, 0.03 * speed) << bounce << " " << speed;
            EXPECT_NEAR(mean.x(), 0, 0.01 * speed);
        }
    }
}

TEST(FeatureTouches, AFastBlockDoesNotPassARail)
{
    const Collider rail = box_below(Vec3(0.04, 0.04, 2));
    for (const double speed : {10.0, 50.0, 200.0}) {
        for (const auto& body : {rigid_block(), make_bricks(block())}) {
            const State state = fallen(
                body, rail, {.height = 1, .speed = speed, .frames = 6, .step = {.substeps = 1}});
            EXPECT_GT(middle(state), 0) << speed;
        }
    }
}

// The rail moves along its length, below a block that it carries by friction.
TEST(FeatureTouches, ARailCarriesABlockAlong)
{
    const BricksBody body = rigid_block();
    State state = rest_state(body);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back(box_below(Vec3(0.06, 0.1, 4)));
    const auto start = loads.colliders[0].pose;
    for (int frame = 0; frame < 24; ++frame) {
        const auto at = [&](int i) {
            return geometry::Transform(Eigen::Translation3d(0, 0, 0.2 * i / 24.0) * start);
        };
        loads.colliders[0].before = at(frame), loads.colliders[0].pose = at(frame + 1);
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 0});
    }
    double z = 0;
    for (const Vec3& x : state.x) z += x.z() / double(state.x.size());
    EXPECT_NEAR(z, 0.15 + 0.2, 0.01);
}

TEST(FeatureTouches, AreTheSameForAnyNumberOfThreads)
{
    const auto fall = [&](std::size_t threads) {
        const tbb::global_control most(tbb::global_control::max_allowed_parallelism, threads);
        return fallen(make_bricks(block()), box_below(Vec3(0.04, 0.1, 2)), {.frames = 12});
    };
    const State one = fall(1), many = fall(4);
    EXPECT_EQ(one.x, many.x);
    EXPECT_EQ(one.v, many.v);
}

geometry::Box all()
{
    geometry::Box out;
    out.add(Vec3::Constant(-10)), out.add(Vec3::Constant(10));
    return out;
}

TEST(ColliderFeatures, ABoxAndItsMeshHaveTheSame)
{
    const auto of_box = features_in(pose_collider(box_below(Vec3(1, 0.4, 0.1)), 1, 1, h), all(), h);
    geometry::TriMesh mesh = geometry::box({1, 0.4, 0.1}, {1, 1, 1});
    for (auto& p : mesh.positions) p += geometry::Vec3f(0.15f, -0.2f, 0.15f);
    auto of_mesh = features_in(pose_collider(mesh_of(mesh), 1, 1, h), all(), h);
    EXPECT_EQ(of_box.size(), 8u + 4 * (39 + 15 + 3));
    ASSERT_EQ(of_box.size(), of_mesh.size());
    for (const FeaturePoint& a : of_box) {
        const auto same = std::find_if(of_mesh.begin(), of_mesh.end(), [&](const auto& b) {
            return (a.place - b.place).norm() < 1e-5;
        });
        ASSERT_NE(same, of_mesh.end()) << a.place.transpose();
        EXPECT_GT(same->outward.dot(a.outward), 0.999);
    }
}

TEST(ColliderFeatures, KeepTheirNumbersInASmallerRegion)
{
    geometry::TriMesh mesh = geometry::box({1, 0.4, 0.1}, {3, 2, 1});
    for (const Collider& c : {box_below(Vec3(1, 0.4, 0.1)), mesh_of(mesh)}) {
        const auto posed = pose_collider(c, 1, 1, h);
        const auto some = features_in(posed, all(), h);
        geometry::Box region = all();
        region.lo.x() = 0.11;
        std::size_t within = 0;
        for (const FeaturePoint& a : features_in(posed, region, h)) {
            const auto same = std::find_if(some.begin(), some.end(),
                                           [&](const auto& b) { return a.number == b.number; });
            ASSERT_NE(same, some.end());
            EXPECT_EQ(same->place, a.place);
            EXPECT_GE(a.place.x(), 0.11);
            ++within;
        }
        EXPECT_GT(within, 8u);
        EXPECT_LT(within, some.size());
    }
}

TEST(ColliderFeatures, WhatIsFlatOrWideAndRoundOrLeadsInHasNone)
{
    Collider ground;
    EXPECT_TRUE(bounds_of_features(pose_collider(ground, 1, 1, h), h).empty());
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.radius = 1;
    EXPECT_TRUE(bounds_of_features(pose_collider(ball, 1, 1, h), h).empty());
    EXPECT_TRUE(
        features_in(pose_collider(mesh_of(geometry::icosphere(1, 4)), 1, 1, h), all(), h).empty());

    // A step up: the edge at its foot leads in, the one at its top out.
    geometry::TriMesh step;
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (const float z : {0.0f, 0.5f}) {
        step.positions.push_back({0, 0, z});
        step.positions.push_back({1, 0, z});
        step.positions.push_back({1, 1, z});
        step.positions.push_back({2, 1, z});
        step.positions.push_back({2, -1, z});
        step.positions.push_back({0, -1, z});
    }
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t j = (i + 1) % 6;
        topology->triangles.push_back({i, i + 6, j});
        topology->triangles.push_back({j, i + 6, j + 6});
    }
    step.topology = topology;
    Collider open = mesh_of(step);  // its ends do not matter here
    bool at_foot = false, at_top = false;
    for (const FeaturePoint& p : features_in(pose_collider(open, 1, 1, h), all(), h)) {
        const bool inner = p.place.z() > 0.05 && p.place.z() < 0.45;
        at_foot |= inner && (p.place - Vec3(1, 0, p.place.z())).norm() < 1e-6;
        at_top |= inner && (p.place - Vec3(1, 1, p.place.z())).norm() < 1e-6;
    }
    EXPECT_FALSE(at_foot);
    EXPECT_TRUE(at_top);
}

// Numbers of those in a region, sorted.
std::vector<std::uint32_t> numbers_in(const PosedCollider& c, const geometry::Box& region)
{
    std::vector<std::uint32_t> out;
    for (const FeaturePoint& p : features_in(c, region, h)) out.push_back(p.number);
    std::sort(out.begin(), out.end());
    return out;
}

TEST(ColliderFeatures, OfAMeshThatStaysAreKept)
{
    geometry::TriMesh mesh = geometry::box({1, 0.4, 0.1}, {3, 2, 1});
    Collider found = mesh_of(mesh), kept = found;
    kept.features = std::make_shared<const KeptFeatures>();
    geometry::Box region;
    region.add(Vec3(-0.11, -0.3, -1)), region.add(Vec3(0.31, 0.1, 1));
    for (const geometry::Box& in : {all(), region}) {
        const auto numbers = numbers_in(pose_collider(found, 1, 1, h), in);
        EXPECT_GT(numbers.size(), 20u);
        EXPECT_EQ(numbers_in(pose_collider(kept, 1, 1, h), in), numbers);
    }
    // Of the size that they are asked for, and where the mesh is.
    const auto posed = pose_collider(kept, 1, 1, h);
    EXPECT_NE(features_in(posed, all(), h / 2).size(), features_in(posed, all(), h).size());
    geometry::TriMesh moved = mesh;
    for (auto& p : moved.positions) p.y() += 1;
    kept.mesh_before = kept.mesh;
    kept.mesh = std::make_shared<const geometry::TriMesh>(moved);
    EXPECT_EQ(pose_collider(kept, 0.5, 1, h).features, nullptr);
}

TEST(ColliderFeatures, OfAMeshWithTooManyAreFoundWhereTheyAreAskedFor)
{
    const geometry::TriMesh mesh = geometry::box({1000, 0.4, 1000}, {1, 1, 1});
    std::vector<const geometry::TriMesh*> many(20, &mesh);
    std::vector<geometry::TriMesh> lifted(20, mesh);
    for (std::size_t i = 0; i < many.size(); ++i) {
        for (auto& p : lifted[i].positions) p.y() += static_cast<float>(i);
        many[i] = &lifted[i];
    }
    Collider found = mesh_of(geometry::merge(many)), kept = found;
    kept.features = std::make_shared<const KeptFeatures>();
    const auto posed = pose_collider(kept, 1, 1, h);
    EXPECT_EQ(kept.features->find(posed, h), nullptr);
    geometry::Box corner;
    corner.add(Vec3(490, -1, 490)), corner.add(Vec3(501, 2, 501));
    const auto numbers = numbers_in(pose_collider(found, 1, 1, h), corner);
    EXPECT_GT(numbers.size(), 100u);
    EXPECT_EQ(numbers_in(posed, corner), numbers);
}

}  // namespace
}  // namespace physics
