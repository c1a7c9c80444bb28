// Bodies of bricks that were turned inside out, pressed flat, pushed through themselves, wound up
// or stretched come back to their rest shape, at one step a frame of 1/24 s.

#include "physics/bricks/bricks.hpp"
#include "physics/bricks/rotation_knots.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using namespace physics;
using geometry::Cubes;
using geometry::Vec3i;

constexpr double length = 0.8, thick = 0.2;

// Damped so that what is left over after 12 s is far below the bar: 24 / s of mass alone take
// e^(-24) off the amplitude of its slow vibrations.
Cubes bar(int across)
{
    return fixtures::box(4 * across, across, across, thick / across,
                         {.young = 1e5, .mass_damping = 4, .stiffness_damping = 0.01});
}

struct Case {
    const char* name;
    bool held;  // at its root, the end at x = 0
    std::function<Vec3(const Vec3&)> deform;
};

Vec3 wound(const Vec3& p, double turns)
{
    const Vec3 axis(0, thick / 2, thick / 2);
    return Eigen::AngleAxisd(2 * std::numbers::pi * turns * p.x() / length, Vec3::UnitX()) *
               (p - axis) +
           axis;
}

// How far it is from its rest shape after 12 s, of its length.
double left_after(const Case& from, int across, const StepOptions& options = {})
{
    const Cubes cubes = bar(across);
    const auto body = make_bricks(cubes);
    const State rest = rest_state(body);
    State state = rest;
    Loads loads;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (from.held && cubes.corner[k].x() == 0) {
            loads.pins.corner.push_back(std::uint32_t(k));
            loads.pins.target.push_back(rest.x[k]);
        } else {
            state.x[k] = from.deform(rest.x[k]);
        }
    }
    for (int i = 0; i < 288; ++i) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
        if (!fixtures::finite(state)) return std::numeric_limits<double>::infinity();
    }
    double worst = 0;
    for (std::size_t k = 0; k < rest.x.size(); ++k) {
        worst = std::max(worst, (state.x[k] - rest.x[k]).norm());
    }
    return (from.held ? worst : fixtures::misfit(rest, state)) / length;
}

constexpr double returned = 1e-3;  // of its length

TEST(Recovery, OfABarInsideOut)
{
    const Case free{"inside out", false, [](const Vec3& p) { return Vec3(-p); }};
    const Case held{"mirrored", true, [](const Vec3& p) { return Vec3(-p.x(), p.y(), p.z()); }};
    EXPECT_LT(left_after(free, 2), returned);
    EXPECT_LT(left_after(held, 2), returned);
}

TEST(Recovery, OfABarPressedToAPlaneALineOrAPoint)
{
    const Case cases[] = {
        {"plane", true, [](const Vec3& p) { return Vec3(p.x(), 0, p.z()); }},
        {"line", true, [](const Vec3& p) { return Vec3(p.x(), 0, 0); }},
        {"point", true, [](const Vec3&) { return Vec3(0.1, 0.2, 0.3); }},
    };
    for (const Case& from : cases) EXPECT_LT(left_after(from, 2), returned) << from.name;
}

TEST(Recovery, OfABarWhoseEndWasPushedThroughItsRoot)
{
    const Case bent{"end through", true, [](const Vec3& p) {
                        const double s = p.x() / length;
                        return Vec3(p.x() * (1 - 2 * s * s), p.y(), p.z());
                    }};
    EXPECT_LT(left_after(bent, 2), returned);
    EXPECT_LT(left_after(bent, 2, {.newton_iterations = 10}), returned);
}

TEST(Recovery, OfABarWoundUpThreeTimes)
{
    const Case from{"wound", true, [](const Vec3& p) { return wound(p, 3); }};
    EXPECT_LT(left_after(from, 2), returned);
}

TEST(Recovery, OfABarStretchedTenTimes)
{
    const Case from{"stretched", true,
                    [](const Vec3& p) { return Vec3(10 * p.x(), p.y(), p.z()); }};
    EXPECT_LT(left_after(from, 2), returned);
}

// The quaternion of a turn about z.
std::array<float, 4> turned(double degrees)
{
    const double half = degrees * std::numbers::pi / 360;
    return {float(std::cos(half)), 0, 0, float(std::sin(half))};
}

// Two rows of four cubes along x: one turns by 180 degrees on the way, the other by as much the
// other way or the same way.
std::vector<float> rows(const Cubes& cubes, double second)
{
    const double along[] = {0, 45, 135, 180};
    std::vector<float> out;
    for (const Vec3i& cell : cubes.cell) {
        const auto q = turned(along[cell.x()] * (cell.y() == 0 ? 1 : second));
        out.insert(out.end(), q.begin(), q.end());
    }
    return out;
}

TEST(RotationKnots, AreFoundWhereRowsFoldInOppositeWaysAndNowhereElse)
{
    const Cubes cubes = fixtures::box(4, 2, 1, 0.1);
    const auto neighbours = find_neighbours(cubes);
    EXPECT_TRUE(undo_knots(cubes, neighbours, rows(cubes, 1), {}).empty());
    EXPECT_TRUE(undo_knots(cubes, neighbours, {}, {}).empty());
    const auto held = undo_knots(cubes, neighbours, rows(cubes, -1), {});
    ASSERT_FALSE(held.empty());
    // What they are held to has no knot.
    std::vector<float> rotation = rows(cubes, -1);
    for (const auto& [cube, q] : held) {
        std::copy(q.begin(), q.end(), rotation.begin() + 4 * std::ptrdiff_t{cube});
    }
    EXPECT_TRUE(undo_knots(cubes, neighbours, rotation, {}).empty());
}

TEST(RotationKnots, DoNotDependOnTheSignsOfQuaternions)
{
    const Cubes cubes = fixtures::box(4, 2, 1, 0.1);
    const auto neighbours = find_neighbours(cubes);
    std::vector<float> rotation = rows(cubes, 1);
    for (std::size_t i = 8; i < 12; ++i) rotation[i] = -rotation[i];
    EXPECT_TRUE(undo_knots(cubes, neighbours, rotation, {}).empty());
}

TEST(RotationKnots, AFullTurnAboutAHoleIsTheBodysOwn)
{
    // A ring of twelve cubes about a hole, each turned by more than the one before, one by 120
    // degrees: 360 in all, which changes the sign once around.
    std::vector<Vec3i> cells;
    for (int i = 0; i < 3; ++i) {
        cells.insert(cells.end(), {{i, 0, 0}, {3, i, 0}, {3 - i, 3, 0}, {0, 3 - i, 0}});
    }
    const Cubes cubes = fixtures::cubes_on(cells, 0.1);
    std::vector<float> rotation;
    for (const Vec3i& c : cubes.cell) {
        const int at = c.y() == 0   ? c.x()
                       : c.x() == 3 ? 3 + c.y()
                       : c.y() == 3 ? 9 - c.x()
                                    : 12 - c.y();
        const auto q = turned(at < 7 ? 20.0 * at : 240 + 24.0 * (at - 7));
        rotation.insert(rotation.end(), q.begin(), q.end());
    }
    EXPECT_TRUE(undo_knots(cubes, find_neighbours(cubes), rotation, {}).empty());
}

TEST(RotationKnots, NeighboursAreThoseThatShareAFace)
{
    const Cubes cubes = fixtures::box(2, 2, 1, 0.1);
    const auto none = geometry::no_index;
    const CubeNeighbours expected{
        {1, 2, none}, {none, 3, none}, {3, none, none}, {none, none, none}};
    EXPECT_EQ(find_neighbours(cubes), expected);
    // Two that meet at an edge only.
    const CubeNeighbours alone{{none, none, none}, {none, none, none}};
    EXPECT_EQ(find_neighbours(fixtures::cubes_on({{0, 0, 0}, {1, 1, 0}}, 0.1)), alone);
}

}  // namespace
