#include "physics/layered_bodies/cube_base.hpp"

#include "geometry/base/random.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using geometry::Skeleton;
using geometry::SkeletonKind;

// A box in the bottom cube of a column of four, and one in the top cube: a frame each.
constexpr double edge = 0.1, half = 0.04, thickness = 0.03;

geometry::Cubes column(const fixtures::Stuff& stuff = {})
{
    return fixtures::box(1, 4, 1, edge, stuff);
}

LayeredBody coated_column(const fixtures::Stuff& stuff, const LayerMatter& matter,
                          double sample_spacing = 0.02)
{
    geometry::ImplicitLayer layer;
    for (std::uint32_t i = 0; i < 2; ++i) {
        Skeleton box{.kind = SkeletonKind::box, .points = {}, .half_size = {half, 0.02, half}};
        box.place.translate(Vec3(0.05, i == 0 ? 0.05 : 0.35, 0.05));
        layer.skeletons.push_back(box);
        layer.contributions.push_back(
            {.thickness = thickness, .stiffness = 1 / thickness, .radius = 2 * thickness});
        layer.frame.push_back(i);
    }
    LayeredBody body = make_layered_body(std::move(layer), BaseKind::still, 1, sample_spacing);
    body.matter = matter;
    set_on_cubes(body, column(stuff));
    return body;
}

LayeredPart part_of(LayeredBody body)
{
    LayeredPart part;
    part.body = std::make_shared<const LayeredBody>(std::move(body));
    return part;
}

LayeredPart free_ball(const Vec3& at, const Vec3& velocity)
{
    geometry::ImplicitLayer layer;
    layer.skeletons = {{.kind = SkeletonKind::point, .points = {at}}};
    layer.contributions = {{.thickness = 0.06, .stiffness = 16, .radius = 0.12}};
    layer.frame = {0};
    LayeredBody body = make_layered_body(std::move(layer), BaseKind::rigid, 1000, 0.01);
    body.matter.stiffness = 1e5;
    LayeredPart part = part_of(std::move(body));
    part.velocity = velocity;
    return part;
}

Vec3 somewhere(const geometry::Random& random, std::uint64_t i)
{
    return {random.unit(3 * i) - 0.5, random.unit(3 * i + 1) - 0.5, random.unit(3 * i + 2) - 0.5};
}

// Corners bent, twisted and stretched, and their velocities.
void disturb(const geometry::Cubes& cubes, std::vector<Vec3>& x, std::vector<Vec3>& v)
{
    const geometry::Random random(11);
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        const Vec3 X = cubes.corner_position(k);
        const Eigen::AngleAxisd turn(2 + 3 * X.y(), Vec3(1, 2, -1).normalized());
        x.push_back(turn * X.cwiseProduct(Vec3(1.3, 0.8, 1.1)) + 0.02 * somewhere(random, k));
        v.push_back(somewhere(random, 1000 + k));
    }
}

Eigen::Matrix<double, 6, 1> twist(const LayeredBody& body, std::size_t f, const FrameHold& hold,
                                  const std::vector<Vec3>& v)
{
    Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t a = 0; a < hold.by.size(); ++a) {
        sum += hold.by[a] * v[body.base.cubes->corners(f)[a]];
    }
    return sum;
}

const LayeredWorld no_gravity{.gravity = Vec3::Zero()};

}  // namespace

TEST(CubeBase, ARigidMotionOfTheCornersIsThatOfTheFrames)
{
    const LayeredBody body = coated_column({}, {});
    Transform move = Transform::Identity();
    move.translate(Vec3(1, 2, 3)).rotate(Eigen::AngleAxisd(2.1, Vec3(2, 1, -1).normalized()));
    const Vec3 linear(0.3, -1, 2), spin(4, -2, 1);
    std::vector<Vec3> x, v;
    const geometry::Cubes cubes = column();
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        x.push_back(move * cubes.corner_position(k));
        v.push_back(linear + spin.cross(x.back()));
    }
    for (std::size_t f = 0; f < 2; ++f) {
        const FrameHold hold = body.base.cubes->hold(f, body.base.frames[f], x);
        EXPECT_LT((hold.moved.matrix() - move.matrix()).norm(), 1e-13);
        const auto moving = twist(body, f, hold, v);
        const Vec3 origin = move * body.base.frames[f].translation();
        EXPECT_LT((moving.head<3>() - linear - spin.cross(origin)).norm(), 1e-12);
        EXPECT_LT((moving.tail<3>() - spin).norm(), 1e-12);
    }
}

// Central differences over 1e-5 s: an error of the third derivative's, some 1e-8, and of rounding
// over the step, 1e-11.
TEST(CubeBase, FramesFollowCornersAsTheirVelocitiesSay)
{
    const LayeredBody body = coated_column({}, {});
    std::vector<Vec3> x, v;
    disturb(column(), x, v);
    constexpr double step = 1e-5;
    const auto at = [&](std::size_t f, double t) {
        std::vector<Vec3> there = x;
        for (std::size_t k = 0; k < x.size(); ++k) there[k] += t * v[k];
        return Transform(body.base.cubes->hold(f, body.base.frames[f], there).moved *
                         body.base.frames[f]);
    };
    for (std::size_t f = 0; f < 2; ++f) {
        const auto moving = twist(body, f, body.base.cubes->hold(f, body.base.frames[f], x), v);
        const Transform before = at(f, -step), after = at(f, step);
        const Vec3 speed = (after.translation() - before.translation()) / (2 * step);
        const Eigen::AngleAxisd turn(after.linear() * before.linear().transpose());
        EXPECT_LT((speed - moving.head<3>()).norm(), 1e-6);
        EXPECT_LT((turn.angle() / (2 * step) * turn.axis() - moving.tail<3>()).norm(), 1e-6);
    }
}

TEST(CubeBase, AWrenchOnAFrameKeepsItsForceAndTorqueOnTheCorners)
{
    const LayeredBody body = coated_column({}, {});
    std::vector<Vec3> x, v;
    disturb(column(), x, v);
    const Vec3 force(3, -2, 5), torque(0.1, 0.4, -0.2);
    Eigen::Matrix<double, 6, 1> wrench;
    wrench << force, torque;
    for (std::size_t f = 0; f < 2; ++f) {
        const FrameHold hold = body.base.cubes->hold(f, body.base.frames[f], x);
        Vec3 sum = Vec3::Zero(), about = Vec3::Zero();
        for (std::size_t a = 0; a < hold.by.size(); ++a) {
            const Vec3 own = hold.by[a].transpose() * wrench;
            sum += own;
            about += x[body.base.cubes->corners(f)[a]].cross(own);
        }
        const Vec3 origin = hold.moved * body.base.frames[f].translation();
        EXPECT_LT((sum - force).norm(), 1e-13);
        EXPECT_LT((about - origin.cross(force) - torque).norm(), 1e-13);
    }
}

// Both take the same implicit steps; what is left is their solvers' tolerance. The column does not
// spin: Simulate starts the steps of a free body that spins from the motion of a rigid one.
TEST(CubeBase, WithoutContactCubesMoveAsSimulateHasThem)
{
    const fixtures::Stuff stuff{.young = 3e4, .mass_damping = 0.3, .stiffness_damping = 0.01};
    LayeredScene scene = start({part_of(coated_column(stuff, {}))});
    const BricksBody bricks = make_bricks(column(stuff));
    State state = rest_state(bricks);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        state.v[k] = Vec3(0.4, 1, 0) + 2 * state.x[k];
    }
    scene.states[0].cubes.v = state.v;
    Loads loads;
    loads.forces.push_back({});
    for (int i = 0; i < 30; ++i) {
        scene = advance(scene, scene.parts, {}, 0.01, 1);
        state = advance(bricks, std::move(state), loads, 0.01, {.tolerance = 1e-11});
    }
    double apart = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        apart = std::max(apart, (state.x[k] - scene.states[0].cubes.x[k]).norm());
    }
    EXPECT_LT(apart, 1e-8);
    EXPECT_EQ(scene.states[0].report.warnings.size(), 0u);
}

// At rest the floor carries the weight W = 4 m g of the column through the bottom box's layer,
// pressed by d: with s = e - d above the floor the box's edges (8 a long in all, and four quarters
// of a circle at the corners) add to its flat face,
//   W = K k (4 a^2 d + 8 a int (e - sqrt(u^2 + s^2)) du + 2 pi int u (e - sqrt(u^2 + s^2)) du).
// The bottom frame hands W half to each of its cube's two planes of corners, planes weigh 1/2, 1,
// 1, 1 and 1/2 m g: cubes from below are pressed by 3/2, 5/2, 3/2 and 1/2 m g. Frames in the middle
// of the lowest and highest come nearer by half of what these two give and all of what the others
// do, (3/4 + 5/2 + 3/2 + 1/4) m g h / (E A).
TEST(CubeBase, ACoatedColumnRestsAndSagsAsItsWeightSays)
{
    const fixtures::Stuff stuff{.young = 5e5, .poisson = 0, .stiffness_damping = 0.05};
    const LayerMatter matter{.stiffness = 1e5, .friction = 1e4, .bulge_height = 0};
    LayeredPart part = part_of(coated_column(stuff, matter, 0.005));
    part.pose.translate(Vec3(0, -0.005, 0));
    Collider ground;
    LayeredScene scene = start({part, rigid_part(ground)});
    for (int i = 0; i < 150; ++i) scene = advance(scene, scene.parts, {}, 1.0 / 60, 2);

    const double mass = 1000 * edge * edge * edge, weight = 4 * mass * 9.81;
    const auto carried = [&](double d) {
        const double s = thickness - d;
        const double reach = std::sqrt(thickness * thickness - s * s);
        double edges = 0, corners = 0;
        constexpr int parts = 1000;
        for (int i = 0; i < parts; ++i) {
            const double u = (i + 0.5) / parts * reach;
            const double g = thickness - std::sqrt(u * u + s * s);
            edges += g * reach / parts;
            corners += u * g * reach / parts;
        }
        return matter.stiffness / thickness *
               (4 * half * half * d + 8 * half * edges + 2 * std::numbers::pi * corners);
    };
    double low = 0, high = 0.5 * thickness;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (carried(middle) < weight ? low : high) = middle;
    }
    const LayeredState& state = scene.states[0];
    const CubeBase& base = *part.body->base.cubes;
    const auto height = [&](std::size_t f) {
        const Vec3 drawn(0.05, f == 0 ? 0.05 : 0.35, 0.05);
        return (base.hold(f, part.body->base.frames[f], state.cubes.x).moved * drawn).y();
    };
    EXPECT_LT(state.velocity[0].norm(), 1e-4);
    // Samples 5 mm apart on a contact 90 mm wide: a hundredth of the depth.
    EXPECT_NEAR(height(0), 0.02 + thickness - low, 0.01 * low);
    const double sag = 5 * mass * 9.81 * edge / (stuff.young * edge * edge);
    EXPECT_NEAR(0.3 - (height(1) - height(0)), sag, 1e-3 * sag);
}

TEST(CubeBase, ContactConservesMomentumBetweenCubesAndBodies)
{
    const fixtures::Stuff stuff{.young = 3e4, .stiffness_damping = 0.01};
    LayeredPart part =
        part_of(coated_column(stuff, {.stiffness = 1e5, .friction = 1e3, .bulge_height = 0}));
    LayeredScene scene = start({part, free_ball({-0.12, 0.38, 0.06}, {2, 0, 0})});
    const double each = 1000 * edge * edge * edge / 8;
    const auto momentum = [&] {
        Vec3 sum = scene.parts[1].body->base.mass[0] * scene.states[1].velocity[0];
        for (const auto& corners : part.body->base.cubes->source().cubes.corners) {
            for (const std::uint32_t k : corners) sum += each * scene.states[0].cubes.v[k];
        }
        return sum;
    };
    const Vec3 before = momentum();
    double taken = 0;
    for (int i = 0; i < 40; ++i) {
        scene = advance(scene, scene.parts, no_gravity, 0.005, 1);
        EXPECT_LT((momentum() - before).norm(), 1e-9 * before.norm());  // the solver's
        taken = before.x() - scene.parts[1].body->base.mass[0] * scene.states[1].velocity[0].x();
    }
    EXPECT_GT(taken, 0.3 * before.x());
}

// Ten times the default step, layers from soft to ten times what a skeleton bears: nothing gets
// faster than by the fall.
TEST(CubeBase, FarTooLongStepsStayStable)
{
    for (const double stiffness : {1e4, 1e6, 1e8}) {
        for (const double young : {1e4, 1e7}) {
            const fixtures::Stuff stuff{.young = young, .stiffness_damping = 0.01};
            LayeredPart part = part_of(
                coated_column(stuff, {.stiffness = stiffness, .friction = 100, .bulge_height = 0}));
            part.pose.translate(Vec3(0, 0.3, 0)).rotate(Eigen::AngleAxisd(0.4, Vec3::UnitZ()));
            LayeredScene scene = start({part, rigid_part(Collider{})});
            double fastest = 0;
            for (int i = 0; i < 12; ++i) {
                scene = advance(scene, scene.parts, {}, 10.0 / 48, 1);
                for (const Vec3& v : scene.states[0].cubes.v) {
                    ASSERT_TRUE(v.allFinite());
                    fastest = std::max(fastest, v.norm());
                }
            }
            // Falling 0.7 m; the upper end of a column that topples is faster by its lever.
            EXPECT_LT(fastest, 1.5 * std::sqrt(2 * 9.81 * 0.7)) << stiffness << ' ' << young;
            EXPECT_GT(scene.states[0].position[0].y(), -0.1) << stiffness << ' ' << young;
        }
    }
}

// Backward Euler of v' = -c v: each step divides by 1 + c dt.
TEST(CubeBase, CubesStartWithTheirPartsVelocityAndFeelDrag)
{
    LayeredPart part = part_of(coated_column({}, {}));
    part.velocity = {1, 2, 3};
    LayeredScene scene = start({part});
    EXPECT_LT((scene.states[0].velocity[1] - part.velocity).norm(), 1e-14);
    scene = advance(scene, scene.parts, {.gravity = Vec3::Zero(), .drag = 2}, 0.1, 5);
    const Vec3 left = part.velocity / std::pow(1 + 2 * 0.02, 5);
    for (const Vec3& v : scene.states[0].cubes.v) EXPECT_LT((v - left).norm(), 1e-10);
    EXPECT_NEAR(fastest(scene), left.norm(), 1e-10);
}

// About their middle, which stays: the column's, a metre aside.
TEST(CubeBase, CubesStartWithTheirPartsSpin)
{
    LayeredPart part = part_of(coated_column({}, {}));
    part.pose.translate(Vec3(1, 0, 0));
    part.spin = {0, 0, 3};
    const LayeredScene scene = start({part});
    const Vec3 middle(1.05, 0.2, 0.05);
    const auto& cubes = scene.states[0].cubes;
    for (std::size_t k = 0; k < cubes.x.size(); ++k) {
        EXPECT_LT((cubes.v[k] - part.spin.cross(cubes.x[k] - middle)).norm(), 1e-12);
    }
}

// A layer that gives way like air: the column comes down to where its skeletons are stopped, a
// tenth of their thickness above the floor by the samples nearest to it; corners of the box,
// between samples, stand lower while it rocks, and out of the floor.
TEST(CubeBase, ASkeletonThatIsStoppedStopsItsCubes)
{
    const fixtures::Stuff stuff{.young = 5e5, .stiffness_damping = 0.05};
    LayeredPart part = part_of(coated_column(stuff, {.stiffness = 1, .friction = 1e3}));
    LayeredScene scene = start({part, rigid_part(Collider{})});
    for (int i = 0; i < 60; ++i) scene = advance(scene, scene.parts, {}, 1.0 / 60, 2);
    const Transform moved =
        part.body->base.cubes->hold(0, part.body->base.frames[0], scene.states[0].cubes.x).moved;
    double lowest = 1;
    for (const double x : {-half, half}) {
        for (const double z : {-half, half}) {
            lowest = std::min(lowest, (moved * Vec3(0.05 + x, 0.03, 0.05 + z)).y());
        }
    }
    EXPECT_GT(lowest, 0);
    EXPECT_LT(lowest, 0.1 * thickness);
}

TEST(CubeBase, WarnsWhereCubesMoveMoreThanTheirSizePerStep)
{
    LayeredScene scene = start({part_of(coated_column({}, {}))});
    scene.states[0].cubes.v[0] = {100, 0,
                                  0};  // a metre in a hundredth of a second, of cubes of 0.1
    scene = advance(scene, scene.parts, no_gravity, 0.01, 1);
    ASSERT_EQ(scene.states[0].report.warnings.size(), 1u);
    EXPECT_FALSE(scene.states[0].report.converged);
}

TEST(CubeBase, TheSameBitsForAnyNumberOfThreads)
{
    const auto run = [](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        LayeredPart part = part_of(coated_column({.young = 3e4}, {.stiffness = 1e5}));
        LayeredScene scene = start({part, rigid_part(Collider{})});
        for (int i = 0; i < 5; ++i) scene = advance(scene, scene.parts, {}, 0.02, 1);
        return scene.states[0].cubes;
    };
    const State one = run(1), two = run(2), eight = run(8);
    EXPECT_EQ(one.x, two.x);
    EXPECT_EQ(one.x, eight.x);
    EXPECT_EQ(one.rotation, eight.rotation);
}

TEST(CubeBase, PinnedCornersGoWhereTheyAreTold)
{
    LayeredPart part = part_of(coated_column({.young = 3e4}, {}));
    const LayeredScene first = start({part});
    for (const std::uint32_t k : {0u, 1u}) {
        part.pins.corner.push_back(k);
        part.pins.target.push_back(first.states[0].cubes.x[k] + Vec3(0.01, 0, 0));
    }
    const LayeredScene scene = advance(first, {part}, {}, 0.02, 3);
    for (std::size_t i = 0; i < 2; ++i) {
        const Vec3 miss = scene.states[0].cubes.x[part.pins.corner[i]] - part.pins.target[i];
        EXPECT_LT(miss.norm(), 1e-15);
        EXPECT_NEAR(scene.states[0].cubes.v[part.pins.corner[i]].x(), 0.5, 1e-12);
    }
    part.pins.corner.back() = 100;
    EXPECT_THROW(advance(first, {part}, {}, 0.02, 1), std::invalid_argument);
}

TEST(CubeBase, CubesThatCannotCarryALayerThrow)
{
    LayeredBody moving = coated_column({}, {});
    EXPECT_THROW(set_on_cubes(moving, column()), std::invalid_argument);  // has a base already
    geometry::ImplicitLayer layer;
    layer.skeletons = {{.kind = SkeletonKind::point, .points = {Vec3::Zero()}}};
    layer.contributions = {{}};
    layer.frame = {0};
    LayeredBody still = make_layered_body(layer, BaseKind::still, 1, 0.05);
    EXPECT_THROW(set_on_cubes(still, {}), std::invalid_argument);  // no cubes
}

}  // namespace physics
