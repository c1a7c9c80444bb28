#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/make_part_shapes.hpp"
#include "physics/body/part_contact.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <set>

namespace physics {
namespace {

using geometry::Vec3i;

constexpr double cube_edge = 0.1;
constexpr int gap = 4;  // cubes, between the arms of a clamp

// A U on its side: a column at x = 0, and two arms of 9 x 2 x 3 cubes at its ends.
geometry::Cubes clamp(const fixtures::Stuff& stuff = {})
{
    std::vector<Vec3i> cells;
    for (int z = 0; z < 3; ++z) {
        for (int y = 0; y < gap + 4; ++y) {
            cells.emplace_back(0, y, z);
            if (y >= 2 && y < gap + 2) continue;
            for (int x = 1; x < 10; ++x) cells.emplace_back(x, y, z);
        }
    }
    return fixtures::cubes_on(cells, cube_edge, stuff);
}

bool on_upper_arm(const geometry::Cubes& cubes, std::size_t k)
{
    return cubes.corner[k].y() >= gap + 2 && cubes.corner[k].x() >= 4;
}
bool on_lower_arm(const geometry::Cubes& cubes, std::size_t k)
{
    return cubes.corner[k].y() <= 2 && cubes.corner[k].x() >= 4;
}

TEST(SelfContact, CubesAroundAreThoseWithinTwoSteps)
{
    const auto cubes = fixtures::blob(3, 80, cube_edge);
    std::vector<std::uint32_t> of;
    for (std::uint32_t c = 0; c < cubes.count(); c += 3) of.push_back(c);
    const PartLists around = cubes_around(cubes.corners, of, cubes.corner_count());
    const auto touch = [&](std::uint32_t a, std::uint32_t b) {
        const std::set<std::uint32_t> corners(cubes.corners[a].begin(), cubes.corners[a].end());
        return std::any_of(cubes.corners[b].begin(), cubes.corners[b].end(),
                           [&](std::uint32_t k) { return corners.contains(k); });
    };
    for (std::size_t i = 0; i < of.size(); ++i) {
        std::vector<std::uint32_t> expected;
        for (std::uint32_t c = 0; c < cubes.count(); ++c) {
            bool near = false;
            for (std::uint32_t d = 0; d < cubes.count() && !near; ++d) {
                near = touch(of[i], d) && touch(d, c);
            }
            if (near) expected.push_back(c);
        }
        const auto found = around[i];
        EXPECT_EQ(std::vector(found.begin(), found.end()), expected) << of[i];
    }
}

// The planes that points are kept behind in a step of 1/100 s that ends at x.
std::vector<PlaneTouch> touches_of(const geometry::Cubes& cubes, const CornerBody& body,
                                   const Aligned<double>& x,
                                   const geometry::TriMesh* surface = nullptr)
{
    const PartShapes shapes = make_part_shapes({cubes, surface}, body, {.self = true});
    const Aligned<double> v(body.numbers, 0);
    const auto pairs = near_parts(shapes, x.data(), v.data(), 0.01);
    return find_part_touches(shapes, pairs, x.data(), v.data(), 0.01, Look::back);
}

// The forces of those that are pressed.
std::vector<PointContact> contacts_of(const geometry::Cubes& cubes, const CornerBody& body,
                                      const Aligned<double>& x,
                                      const geometry::TriMesh* surface = nullptr)
{
    const Aligned<double> v(body.numbers, 0);
    return press(touches_of(cubes, body, x, surface), x.data(), v.data(), 0.01, 0);
}

TEST(SelfContact, ABodyAtRestOrBentALittleDoesNotTouchItself)
{
    const auto cubes = clamp();
    const CornerBody body = make_corner_body(cubes, {}, nullptr);
    Aligned<double> x = body.rest;
    EXPECT_TRUE(contacts_of(cubes, body, x).empty());
    for (std::size_t k = 0; k < body.corners; ++k) {  // squeezed and sheared
        x[4 * k] += 0.4 * x[4 * k + 1];
        x[4 * k + 1] *= 0.6;
    }
    EXPECT_TRUE(contacts_of(cubes, body, x).empty());
}

// The upper arm lowered until it is 3 mm deep in the lower one.
TEST(SelfContact, TheDepthIsThatOfThePointInTheOtherArm)
{
    const auto cubes = clamp();
    const CornerBody body = make_corner_body(cubes, {}, nullptr);
    Aligned<double> x = body.rest;
    for (std::size_t k = 0; k < body.corners; ++k) {
        if (cubes.corner[k].y() >= gap + 2) x[4 * k + 1] -= gap * cube_edge + 0.003;
    }
    const auto contacts = contacts_of(cubes, body, x);
    ASSERT_GT(contacts.size(), 100u);  // of 9 x 3 faces on each side
    std::size_t deep = 0;
    Vec3 sum = Vec3::Zero();
    for (const PointContact& c : contacts) {
        deep += std::abs(2 * c.energy / c.force.norm() - 0.003) < 1e-6 ? 1 : 0;
        double weights = 0;
        for (std::size_t a = 0; a < c.count; ++a) {
            weights += double(c.weight[a]);
            sum += double(c.weight[a]) * c.force;
        }
        EXPECT_NEAR(weights, 0, 1e-6);
    }
    EXPECT_GE(deep, contacts.size() * 9 / 10);  // not those of the crushed column
    EXPECT_LT(sum.norm(), 1e-3 * contacts.front().force.norm());
}

// A thin finger and a thick one, 7 cubes long, on a base, half a cube apart, so that a cell holds a
// piece of each.
struct Fingers {
    Fingers()
    {
        const auto box = [](const Vec3& lo, const Vec3& hi) {
            auto out = geometry::box(cube_edge * (hi - lo), {1, 1, 1});
            for (auto& p : out.positions) p += (0.5 * cube_edge * (lo + hi)).cast<float>();
            return out;
        };
        const auto base = box({0, 0.1, 0.1}, {3.1, 0.9, 1.9});
        const auto left = box({0.9, 0.5, 0.1}, {1.3, 8, 1.9});
        const auto right = box({1.8, 0.5, 0.1}, {3.1, 8, 1.9});
        const std::array<const geometry::TriMesh*, 3> all{&base, &left, &right};
        mesh = geometry::merge(all);
        cubes = geometry::voxelize_solid(mesh, {{}, {{}}, {}}, geometry::Inside::winding, 0,
                                         {cube_edge, Vec3::Zero(), Vec3i::Zero()},
                                         {.pieces = geometry::NearPieces::apart});
        body = make_corner_body(cubes, {}, &mesh);
        is_left.assign(cubes.corner_count(), 0);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const int column = cubes.cell[c].x();
            const bool low = !cubes.part.empty() && (cubes.part[c] & 0x1111'1111'1111'1111u) != 0;
            if (cubes.cell[c].y() < 1 || !(column == 0 || (column == 1 && low))) continue;
            for (const auto k : cubes.corners[c]) is_left[k] = 1;
        }
    }
    // The fingers' tips are turned by `towards` (m) towards each other.
    Aligned<double> bent(double towards) const
    {
        Aligned<double> x = body.rest;
        for (std::size_t k = 0; k < body.corners; ++k) {
            const double share = std::max(0.0, cubes.corner[k].y() - 1.0) / 7;
            x[4 * k] += (is_left[k] != 0 ? towards : -towards) * share;
        }
        return x;
    }

    geometry::TriMesh mesh;
    geometry::Cubes cubes;
    CornerBody body;
    std::vector<char> is_left;
};

TEST(SelfContact, PiecesThatShareACellTouchWhereTheyMeetOnly)
{
    const Fingers f;
    ASSERT_FALSE(f.cubes.part.empty());
    EXPECT_TRUE(touches_of(f.cubes, f.body, f.body.rest, &f.mesh).empty());
    EXPECT_TRUE(touches_of(f.cubes, f.body, f.bent(-0.6 * cube_edge), &f.mesh).empty());  // spread
    EXPECT_TRUE(contacts_of(f.cubes, f.body, f.bent(0.24 * cube_edge), &f.mesh).empty());
    const auto contacts = contacts_of(f.cubes, f.body, f.bent(0.3 * cube_edge), &f.mesh);
    EXPECT_GT(contacts.size(), 4u);
    for (const PointContact& c : contacts) {
        EXPECT_GT(std::abs(c.force.normalized().x()), 0.99);
        EXPECT_LT(2 * c.energy / c.force.norm(), 0.1 * cube_edge + 1e-6);
    }
}

// The lowest corner of the upper arm above the highest of the lower one, m.
double between_arms(const geometry::Cubes& cubes, const State& state)
{
    double up = 1e9, low = -1e9;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (on_upper_arm(cubes, k)) up = std::min(up, state.x[k].y());
        if (on_lower_arm(cubes, k)) low = std::max(low, state.x[k].y());
    }
    return up - low;
}

// The arms are thrown at each other at 3 m/s each, in a step a frame.
TEST(SelfContact, ArmsThatMeetDoNotPassThroughEachOther)
{
    const auto cubes = clamp({.young = 1e5, .stiffness_damping = 0.005});
    const auto thrown = [&](const auto& body, double& least) {
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            if (on_upper_arm(cubes, k)) state.v[k].y() = -3;
            if (on_lower_arm(cubes, k)) state.v[k].y() = 3;
        }
        const auto before = fixtures::brick_motion(cubes, state);
        least = 1;
        for (int frame = 0; frame < 12; ++frame) {
            state = advance(body, state, {}, 1.0 / 24);
            ASSERT_TRUE(fixtures::finite(state));
            least = std::min(least, between_arms(cubes, state));
        }
        const auto after = fixtures::brick_motion(cubes, state);
        EXPECT_LT((after.linear - before.linear).norm(), 1e-2);  // of 100 kg at 3 m/s
    };
    const PartContactOptions touching{.self = true};
    double least = 0;
    thrown(make_bricks(cubes, {.contact = touching}), least);
    EXPECT_GT(least, -0.1 * cube_edge);
    EXPECT_LT(least, 0.1 * cube_edge);
    thrown(make_springs(cubes, {.contact = touching}), least);
    EXPECT_GT(least, -0.1 * cube_edge);
    thrown(make_bricks(cubes, {.contact = {.self = false}}), least);
    EXPECT_LT(least, -cube_edge);  // without it they pass
}

TEST(SelfContact, ABodyFarFromItselfMovesAsWithoutIt)
{
    const auto cubes = clamp({.young = 1e6, .stiffness_damping = 0.005});
    const auto moved = [&](bool self) {
        const BricksBody body = make_bricks(cubes, {.contact = {.self = self}});
        State state = rest_state(body);
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            if (on_upper_arm(cubes, k)) state.v[k].z() = 0.2;
        }
        for (int frame = 0; frame < 3; ++frame) state = advance(body, state, {}, 1.0 / 24);
        return state;
    };
    const State with = moved(true), without = moved(false);
    for (std::size_t k = 0; k < with.x.size(); ++k) {
        EXPECT_LT((with.x[k] - without.x[k]).norm(), 1e-6);
    }
}

}  // namespace
}  // namespace physics
