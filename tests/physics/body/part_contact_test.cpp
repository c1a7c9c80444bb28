#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/closed_shape.hpp"
#include "physics/body/make_part_shapes.hpp"
#include "physics/body/part_contact.hpp"
#include "physics/body/part_gap.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace physics {
namespace {

using geometry::Mat3;
using geometry::Vec3i;

// Boxes of cubes, each by its first cell and its size.
geometry::Cubes boxes(const std::vector<std::array<Vec3i, 2>>& of, double h,
                      const fixtures::Stuff& stuff = {})
{
    std::vector<Vec3i> cells;
    for (const auto& [first, size] : of) {
        for (int z = 0; z < size.z(); ++z) {
            for (int y = 0; y < size.y(); ++y) {
                for (int x = 0; x < size.x(); ++x) cells.emplace_back(first + Vec3i(x, y, z));
            }
        }
    }
    return fixtures::cubes_on(cells, h, stuff);
}

constexpr double h = 0.1;

// A block of 3 cubes each way, and a smaller one above it.
struct TwoBlocks {
    geometry::Cubes cubes =
        boxes({{Vec3i(0, 0, 0), Vec3i(3, 3, 3)}, {Vec3i(1, 5, 1), Vec3i(1, 1, 1)}}, h,
              {.young = 2e5, .stiffness_damping = 0.01});
    CornerBody body = make_corner_body(cubes, {}, nullptr);
    PartShapes shapes = make_part_shapes({cubes, nullptr}, body, {.friction = 0.5});
    Aligned<double> x = body.rest, v = Aligned<double>(body.numbers, 0);

    // Moves all corners of the part that corner 0 is in, or of the other one.
    template <class Move> void move(bool upper, const Move& move)
    {
        for (std::size_t k = 0; k < body.corners; ++k) {
            if ((cubes.corner[k].y() >= 5) != upper) continue;
            Eigen::Map<Vec3> p(x.data() + 4 * k);
            p = move(Vec3(p));
        }
    }
    std::vector<PointContact> contacts() const
    {
        const auto pairs = near_parts(shapes, x.data(), v.data(), 0.01);
        return press(find_part_touches(shapes, pairs, x.data(), v.data(), 0.01, Look::back),
                     x.data(), v.data(), 0.01, 0);
    }
};

TEST(PartShapes, TheOutsideOfCubesIsClosedAndHoldsTheirVolume)
{
    const auto cubes = fixtures::blob(5, 60, h);
    std::vector<std::uint32_t> all(cubes.count());
    for (std::uint32_t c = 0; c < all.size(); ++c) all[c] = c;
    const geometry::TriMesh mesh = outside_of(cubes, all);
    EXPECT_NEAR(geometry::enclosed_volume(mesh), double(cubes.count()) * h * h * h, 1e-6);
}

TEST(PartShapes, APartHasItsOwnClosedTrianglesOrTheOutsideOfItsCubes)
{
    const auto cubes =
        boxes({{Vec3i(0, 0, 0), Vec3i(2, 2, 2)}, {Vec3i(5, 0, 0), Vec3i(2, 2, 2)}}, h);
    // A closed box of 0.16 in the first block, a sheet in the second one.
    geometry::TriMesh surface = geometry::box({0.16, 0.16, 0.16}, {1, 1, 1});
    for (auto& p : surface.positions) p += geometry::Vec3f::Constant(0.1f);
    geometry::MeshTopology topology = *surface.topology;
    const auto first = static_cast<std::uint32_t>(surface.positions.size());
    for (const auto& p : {geometry::Vec3f(0.52f, 0.1f, 0.02f), geometry::Vec3f(0.68f, 0.1f, 0.02f),
                          geometry::Vec3f(0.52f, 0.1f, 0.18f)}) {
        surface.positions.push_back(p);
    }
    topology.triangles.push_back({first, first + 1, first + 2});
    topology.normal_triangles.clear();
    surface.normals.clear();
    surface.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    const CornerBody body = make_corner_body(cubes, {}, &surface);
    const PartShapes shapes = make_part_shapes({cubes, &surface}, body, {.friction = 0.5});
    ASSERT_EQ(shapes.parts(), 2u);
    EXPECT_TRUE(shapes.shape[0].inside(Vec3(0.1, 0.1, 0.03)));
    EXPECT_FALSE(shapes.shape[0].inside(Vec3(0.1, 0.1, 0.01)));
    EXPECT_TRUE(shapes.shape[1].inside(Vec3(0.55, 0.01, 0.01)));
}

// The points of the face of a cube between which its edges are cut in two, near the corners of
// eight triangles and taken together by quarters, and two of the face below that lie under it.
constexpr std::size_t points_of_face = 18 + 2;

TEST(PartContact, NothingTouchesAtRest)
{
    EXPECT_TRUE(TwoBlocks().contacts().empty());
}

// The upper block pressed 3 mm into the top of the lower one.
TEST(PartContact, TheDepthIsThatOfThePointInTheOtherPart)
{
    TwoBlocks two;
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0.03, 0.203, 0.04)); });
    const auto contacts = two.contacts();
    ASSERT_EQ(contacts.size(), points_of_face);
    for (const PointContact& c : contacts) {
        EXPECT_EQ(c.count, 16u);
        EXPECT_NEAR(2 * c.energy / c.force.norm(), 0.003, 1e-6);
        EXPECT_NEAR(std::abs(c.force.normalized().y()), 1, 1e-9);
    }
}

// Points 3 mm deep that are 0.5 mm from a side of the lower block: the top is what they came
// through.
TEST(PartContact, APointNearARimLeavesThroughTheSideThatFacesIt)
{
    TwoBlocks two;
    two.move(true, [](const Vec3& p) { return Vec3(p + Vec3(0.1045, -0.203, 0.03)); });
    const auto contacts = two.contacts();
    ASSERT_GT(contacts.size(), 4u);
    for (const PointContact& c : contacts) EXPECT_NEAR(std::abs(c.force.normalized().y()), 1, 1e-6);
}

// The same with both turned and stretched: the depth is stretched as the matter is.
TEST(PartContact, TheDepthTurnsAndStretchesWithTheOtherPart)
{
    TwoBlocks two;
    Mat3 f = Mat3(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
    const Vec3 up = f.col(1);
    f = f * Vec3(1.2, 1.5, 0.8).asDiagonal();
    two.move(true, [&](const Vec3& p) { return Vec3(f * (p - Vec3(0.03, 0.203, 0.04))); });
    two.move(false, [&](const Vec3& p) { return Vec3(f * p); });
    const auto contacts = two.contacts();
    ASSERT_EQ(contacts.size(), points_of_face);
    for (const PointContact& c : contacts) {
        EXPECT_NEAR(2 * c.energy / c.force.norm(), 1.5 * 0.003, 1e-6);
        EXPECT_NEAR(std::abs(c.force.normalized().dot(up)), 1, 1e-6);
    }
}

TEST(PartContact, ForcesKeepMomentumAndAngularMomentum)
{
    TwoBlocks two;
    const Mat3 turn(Eigen::AngleAxisd(0.3, Vec3(1, 0, 2).normalized()));
    two.move(true, [&](const Vec3& p) {
        return Vec3(turn * (p - Vec3(0.15, 0.55, 0.15)) + Vec3(0.13, 0.34, 0.14));
    });
    for (std::size_t k = 0; k < two.body.corners; ++k) two.v[4 * k] = 0.1 * double(k % 7);
    const auto contacts = two.contacts();
    ASSERT_FALSE(contacts.empty());
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    double size = 0;
    for (const PointContact& c : contacts) {
        for (std::size_t a = 0; a < c.count; ++a) {
            const Vec3 p = Eigen::Map<const Vec3>(two.x.data() + 4 * std::size_t{c.corners[a]});
            force += double(c.weight[a]) * c.force;
            torque += p.cross(double(c.weight[a]) * c.force);
        }
        size += c.force.norm();
    }
    EXPECT_LT(force.norm(), 1e-6 * size);
    EXPECT_LT(torque.norm(), 1e-6 * size);
}

// The upper block 1 cm above the lower one, about to fall on it: its points are before the top, and
// those of its sides are before nothing.
TEST(PartContact, PointsThatMayComeToAFaceAreFoundBeforeTheyDo)
{
    TwoBlocks two;
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0.03, 0.19, 0.04)); });
    const auto pairs = near_parts(two.shapes, two.x.data(), two.v.data(), 0.01);
    const auto touches =
        find_part_touches(two.shapes, pairs, two.x.data(), two.v.data(), 0.01, Look::ahead);
    ASSERT_EQ(touches.size(), points_of_face);
    for (const PlaneTouch& touch : touches) {
        EXPECT_NEAR(touch.gap(two.x.data()), 0.01, 1e-6);
        EXPECT_NEAR(std::abs(touch.normal.y()), 1, 1e-9);
    }
    EXPECT_TRUE(press(touches, two.x.data(), two.v.data(), 0.01, 0).empty());
    // Both planes go with the corners.
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0, 0.013, 0)); });
    for (const PlaneTouch& touch : touches) EXPECT_NEAR(touch.gap(two.x.data()), -0.003, 1e-6);
    EXPECT_EQ(press(touches, two.x.data(), two.v.data(), 0.01, 0).size(), points_of_face);
}

// The upper block 0.6 cubes above the lower one. What comes to within 0.3 cubes in a step of 0.01 s
// is told of: at 5 m/s down, 0.1 cubes; at 2 m/s, only to 0.4.
TEST(PartContact, PointsAreFoundAheadWhereTheyComeNearAFace)
{
    TwoBlocks two;
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0.03, 0.14, 0.04)); });
    const auto found = [&](const Vec3& velocity) {
        for (std::size_t k = 0; k < two.body.corners; ++k) {
            if (two.cubes.corner[k].y() < 5) continue;
            Eigen::Map<Vec3>(two.v.data() + 4 * k) = velocity;
        }
        const auto pairs = near_parts(two.shapes, two.x.data(), two.v.data(), 0.01);
        return find_part_touches(two.shapes, pairs, two.x.data(), two.v.data(), 0.01, Look::ahead)
            .size();
    };
    EXPECT_EQ(found({0, -5, 0}), points_of_face);
    EXPECT_EQ(found({0, -2, 0}), 0u);
    EXPECT_EQ(found({5, 0, 0}), 0u);
    EXPECT_EQ(found({0, 5, 0}), 0u);
}

TEST(PartContact, PointsThatAreKnownToTouchAPartAreNotLookedAt)
{
    TwoBlocks two;
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0.03, 0.203, 0.04)); });
    const auto pairs = near_parts(two.shapes, two.x.data(), two.v.data(), 0.01);
    const auto found = [&](const std::vector<PlaneTouch>& known) {
        return find_part_touches(two.shapes, pairs, two.x.data(), two.v.data(), 0.01, Look::back,
                                 known);
    };
    const auto all = found({});
    ASSERT_EQ(all.size(), points_of_face);
    EXPECT_TRUE(found(all).empty());
    // All but the fourth; it comes back to its place, with the plane that it had.
    auto known = all;
    known.erase(known.begin() + 3);
    const auto again = found(known);
    ASSERT_EQ(again.size(), 1u);
    EXPECT_EQ(again[0].point, all[3].point);
    EXPECT_EQ(again[0].offset, all[3].offset);
    EXPECT_TRUE(add_found(known, again, two.x.data(), 0.001));  // 3 mm deep
    ASSERT_EQ(known.size(), points_of_face);
    for (std::size_t i = 0; i < points_of_face; ++i) EXPECT_EQ(known[i].point, all[i].point);
}

// Two blocks of one width, one pressed 2 cm into the other: points of their sides lie in the other
// block's side. A way out through the far side would throw them off each other.
TEST(PartContact, SidesThatAreFlushAreNotPushed)
{
    const auto cubes =
        boxes({{Vec3i(0, 0, 0), Vec3i(2, 2, 2)}, {Vec3i(0, 3, 0), Vec3i(2, 2, 2)}}, h);
    const CornerBody body = make_corner_body(cubes, {}, nullptr);
    const PartShapes shapes = make_part_shapes({cubes, nullptr}, body, {.friction = 0.5});
    Aligned<double> x = body.rest;
    const Aligned<double> v(body.numbers, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        if (cubes.corner[k].y() >= 3) x[4 * k + 1] -= 0.12;
    }
    const auto pairs = near_parts(shapes, x.data(), v.data(), 0.01);
    const auto contacts =
        press(find_part_touches(shapes, pairs, x.data(), v.data(), 0.01, Look::back), x.data(),
              v.data(), 0.01, 0);
    ASSERT_GT(contacts.size(), 16u);
    for (const PointContact& c : contacts) EXPECT_NEAR(std::abs(c.force.normalized().y()), 1, 1e-6);
}

// A sphere, in cubes whose middles lie in it and outside of it.
TEST(PartContact, APlaceIsInsideOfAShapeWhereItsWindingNumberSaysSo)
{
    const auto cubes =
        boxes({{Vec3i(0, 0, 0), Vec3i(4, 4, 4)}, {Vec3i(9, 0, 0), Vec3i(1, 1, 1)}}, h);
    geometry::TriMesh ball = geometry::icosphere(0.17, 2);
    for (auto& p : ball.positions) p += geometry::Vec3f(0.21f, 0.19f, 0.2f);
    const CornerBody body = make_corner_body(cubes, {}, nullptr);
    const PartShapes shapes = make_part_shapes({cubes, &ball}, body, {});
    const geometry::Random random(5);
    std::array<int, 2> found{};
    for (std::uint32_t c = 0; c < 64; ++c) {
        EXPECT_NE(shapes.winding[c], unknown_winding);
        for (std::uint64_t i = 0; i < 10; ++i) {
            Vec3 u;
            for (unsigned k = 0; k < 3; ++k) u[k] = 1.6 * random.unit(30 * c + 3 * i + k) - 0.3;
            const AtRest rest(shapes, body.part_of(shapes.corners[c][0]), c,
                              {u, Mat3(h * Mat3::Identity())});
            EXPECT_EQ(rest.inside(), rest.shape.inside(rest.place)) << u.transpose();
            ++found.at(rest.inside() ? 1 : 0);
        }
    }
    EXPECT_GT(found[0], 100);
    EXPECT_GT(found[1], 100);
}

// A point that is held is pulled back by the stretch that it has, up to mu N.
TEST(PartContact, FrictionIsASpringThatYields)
{
    TwoBlocks two;
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0.03, 0.203, 0.04)); });
    const auto pairs = near_parts(two.shapes, two.x.data(), two.v.data(), 0.01);
    auto touches =
        find_part_touches(two.shapes, pairs, two.x.data(), two.v.data(), 0.01, Look::back);
    for (const double dragged : {0.0005, 0.01}) {
        std::vector<Grip> grips;
        for (const PlaneTouch& touch : touches) {
            grips.push_back(
                {touch.point, touch.other, {static_cast<float>(dragged), 0.1f, 0}, {}, 0});
        }
        take_grips(touches, grips);
        const auto contacts = press(touches, two.x.data(), two.v.data(), 0.01, 0);
        ASSERT_EQ(contacts.size(), touches.size());
        for (std::size_t i = 0; i < contacts.size(); ++i) {
            const double k = touches[i].stiffness;
            EXPECT_NEAR(contacts[i].force.x(), -k * std::min(dragged, 0.5 * 0.003),
                        1e-4 * k * 0.003);
            EXPECT_NEAR(std::abs(contacts[i].force.y()), k * 0.003, 1e-3 * k * 0.003);
        }
        for (const Grip& grip : grips_of(touches, {two.x.data(), two.x.data(), 0.01})) {
            EXPECT_NEAR(double(grip.stretch.x()), std::min(dragged, 0.5 * 0.003), 1e-6);
            EXPECT_NEAR(double(grip.stretch.y()), 0, 1e-6);
        }
    }
    // Held at 3 mm, friction yields as it did, however deep the points are pressed then.
    hold_loads(touches, two.x.data());
    two.move(true, [](const Vec3& p) { return Vec3(p - Vec3(0, 0.006, 0)); });
    const auto deeper = press(touches, two.x.data(), two.v.data(), 0.01, 0);
    ASSERT_EQ(deeper.size(), touches.size());
    for (std::size_t i = 0; i < deeper.size(); ++i) {
        const double k = touches[i].stiffness;
        EXPECT_NEAR(deeper[i].force.x(), -k * 0.5 * 0.003, 1e-4 * k * 0.003);
        EXPECT_NEAR(std::abs(deeper[i].force.y()), k * 0.009, 1e-3 * k * 0.009);
    }
}

TEST(PartContact, IsTheSameForAnyNumberOfThreads)
{
    std::vector<std::array<Vec3i, 2>> heap;
    for (int i = 0; i < 27; ++i) {
        heap.push_back({Vec3i(4 * (i % 3), 4 * (i / 3 % 3), 4 * (i / 9)), Vec3i(3, 3, 3)});
    }
    const auto cubes = boxes(heap, h, {.young = 2e5});
    const CornerBody body = make_corner_body(cubes, {}, nullptr);
    const PartShapes shapes = make_part_shapes({cubes, nullptr}, body, {.friction = 0.5});
    // Squeezed into less room than they have: corners of blocks lie in other blocks.
    Aligned<double> x = body.rest, v(body.numbers, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        const Vec3 cell = cubes.corner[k].cast<double>();
        const Vec3 block = (cell / 4).array().floor();
        for (Eigen::Index i = 0; i < 3; ++i) {
            x[4 * k + std::size_t(i)] -= h * (1.2 + 0.05 * double(i)) * block[i];
        }
    }
    const auto find = [&](std::size_t threads) {
        const tbb::global_control most(tbb::global_control::max_allowed_parallelism, threads);
        const auto pairs = near_parts(shapes, x.data(), v.data(), 0.01);
        return press(find_part_touches(shapes, pairs, x.data(), v.data(), 0.01, Look::back),
                     x.data(), v.data(), 0.01, 0);
    };
    const auto one = find(1), many = find(4);
    ASSERT_GT(one.size(), 100u);
    ASSERT_EQ(one.size(), many.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
        EXPECT_EQ(one[i].corners, many[i].corners);
        EXPECT_EQ(one[i].force, many[i].force);
    }
}

State stepped(const auto& body, State state, const Loads& loads, int frames, int substeps = 1)
{
    for (int i = 0; i < frames; ++i) {
        state = advance(body, state, loads, 1.0 / 24, StepOptions{.substeps = substeps});
    }
    return state;
}

// Mean place and velocity of the corners that began above `row`.
struct Mean {
    Vec3 x = Vec3::Zero(), v = Vec3::Zero();
};
Mean mean_of(const geometry::Cubes& cubes, const State& state, int from, int to)
{
    Mean out;
    double count = 0;
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].y() < from || cubes.corner[k].y() > to) continue;
        out.x += state.x[k];
        out.v += state.v[k];
        count += 1;
    }
    out.x /= count;
    out.v /= count;
    return out;
}

// Two blocks thrown at each other, 0.1 m apart, at 2 m/s each.
TEST(PartContact, BodiesThatCollideKeepMomentumAndDoNotPass)
{
    auto cubes = boxes({{Vec3i(0, 0, 0), Vec3i(3, 3, 3)}, {Vec3i(0, 4, 0), Vec3i(3, 3, 3)}}, h,
                       {.young = 2e5, .stiffness_damping = 0.002});
    const auto collide = [&](const auto& body) {
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            state.v[k].y() = cubes.corner[k].y() >= 4 ? -2 : 2;
        }
        state = stepped(body, state, {}, 12, 4);
        ASSERT_TRUE(fixtures::finite(state));
        const Mean low = mean_of(cubes, state, 0, 3), high = mean_of(cubes, state, 4, 7);
        EXPECT_GT(high.x.y() - low.x.y(), 0.3);
        EXPECT_GT(high.v.y(), 0.1);
        EXPECT_NEAR(high.v.y() + low.v.y(), 0, 5e-3);
    };
    collide(make_bricks(cubes, {.contact = {.friction = 0.5}}));
    collide(make_springs(cubes, {.contact = {.friction = 0.5}}));
    // Without contact they pass through each other.
    const BricksBody free = make_bricks(cubes);
    State state = rest_state(free);
    for (std::size_t k = 0; k < state.v.size(); ++k) {
        state.v[k].y() = cubes.corner[k].y() >= 4 ? -2 : 2;
    }
    state = stepped(free, state, {}, 12, 4);
    EXPECT_LT(mean_of(cubes, state, 4, 7).x.y(), mean_of(cubes, state, 0, 3).x.y());
}

// Four blocks dropped onto each other and a plane: they come to rest as a stack.
TEST(PartContact, AStackComesToRest)
{
    std::vector<std::array<Vec3i, 2>> stack;
    for (int i = 0; i < 4; ++i) stack.push_back({Vec3i(0, 3 * i, 0), Vec3i(2, 2, 2)});
    const auto cubes = boxes(stack, h, {.young = 5e5, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State state = stepped(body, rest_state(body), loads, 72, 2);
    const State later = stepped(body, state, loads, 24, 2);
    double moved = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        moved = std::max(moved, (later.x[k] - state.x[k]).norm());
    }
    EXPECT_LT(moved, 1e-3);
    for (int i = 0; i + 1 < 4; ++i) {
        const double top = mean_of(cubes, later, 3 * i + 2, 3 * i + 2).x.y();
        const double bottom = mean_of(cubes, later, 3 * i + 3, 3 * i + 3).x.y();
        EXPECT_NEAR(bottom - top, 0, 0.01 * h) << i;
    }
}

// Ten blocks that begin as a stack stand still for two seconds, a step a frame.
TEST(PartContact, ATallStackStandsStill)
{
    std::vector<std::array<Vec3i, 2>> stack;
    for (int i = 0; i < 10; ++i) stack.push_back({Vec3i(0, 3 * i, 0), Vec3i(2, 2, 2)});
    const auto cubes = boxes(stack, h, {.young = 5e7, .stiffness_damping = 0.01});
    const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        const int block = cubes.corner[k].y() / 3;
        state.x[k].y() -= h * block;
    }
    state = stepped(body, state, loads, 24);
    const State later = stepped(body, state, loads, 24);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        EXPECT_LT((later.x[k] - state.x[k]).norm(), 1e-5);
        const int row = cubes.corner[k].y(), block = row / 3;
        EXPECT_NEAR(later.x[k].y(), h * (row - block), 1e-3);
    }
}

// A block on a block that is held and tilted: friction 0.5, whose angle is 26.57 degrees, holds at
// 26 and not at 27.
TEST(PartContact, FrictionHoldsBelowItsAngleOnly)
{
    const auto cubes = boxes({{Vec3i(0, 0, 0), Vec3i(8, 1, 3)}, {Vec3i(3, 2, 1), Vec3i(2, 1, 1)}},
                             h, {.young = 1e6, .stiffness_damping = 0.01});
    const auto slid = [&](double degrees, int frames) {
        const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
        State state = rest_state(body);
        Loads loads;
        const double angle = degrees * std::numbers::pi / 180;
        loads.forces.push_back({.acceleration = 9.81 * Vec3(std::sin(angle), -std::cos(angle), 0)});
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k].y() >= 2) {
                state.x[k].y() -= h;  // lies on it
            } else {
                loads.pins.corner.push_back(k);
                loads.pins.target.push_back(state.x[k]);
            }
        }
        state = stepped(body, state, loads, frames);
        return mean_of(cubes, state, 2, 3).x.x() - 0.4;
    };
    EXPECT_LT(slid(26, 24), 0.002);
    EXPECT_NEAR(slid(27, 24), 0.042, 0.006);  // 0.5 g (sin - 0.5 cos) for a second
    // What holds does not creep.
    EXPECT_NEAR(slid(20, 240), slid(20, 48), 1e-5);
}

// A light block at a plate one cube thick: at 8 m/s it goes 0.33 m in a step, at 500 m/s 21 m. It
// begins somewhere before the plate, so that the places where it is looked for fall on either side.
TEST(PartContact, AFastBlockDoesNotPassThroughAPlate)
{
    const auto cubes = boxes({{Vec3i(0, 0, 0), Vec3i(5, 1, 5)}, {Vec3i(2, 4, 2), Vec3i(1, 1, 1)}},
                             h, {.young = 5e5, .stiffness_damping = 0.005});
    const BricksBody body = make_bricks(cubes, {.contact = {.friction = 0.5}});
    Loads loads;
    State state = rest_state(body);
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].y() >= 4) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(state.x[k]);
    }
    for (const double speed : {8.0, 20.0, 40.0, 150.0, 320.0, 500.0}) {
        for (const double from : {0.0, 0.003, 0.011, 0.017}) {
            State start = state;
            for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
                if (cubes.corner[k].y() < 4) continue;
                start.v[k].y() = -speed;
                start.x[k].y() += from * speed;
            }
            for (const int substeps : {1, 4}) {
                const State end = stepped(body, start, loads, 12, substeps);
                EXPECT_GT(mean_of(cubes, end, 4, 5).x.y(), 0.1)
                    << speed << " m/s, " << from << ", " << substeps;
            }
        }
    }
}

}  // namespace
}  // namespace physics
