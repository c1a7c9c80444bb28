#include "geometry/mesh/copies.hpp"

#include "geometry/base/srgb.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

TEST(Copies, StandInRowsAboutTheMiddle)
{
    const TriMesh one = box({0.2, 0.2, 0.2}, {1, 1, 1});
    const TriMesh all = copies(one, {{3, 2, 4}, {1, 2, 0.5}, {0.25, 0, 0}, 0});
    meshes::expect_consistent(all);
    EXPECT_EQ(all.positions.size(), 24 * one.positions.size());
    EXPECT_EQ(all.triangles().size(), 24 * one.triangles().size());
    // Along x: 2 steps of 1, half a box at each end, and the second layer 0.25 further.
    const Box whole = bounds(all);
    EXPECT_NEAR(whole.size()[0], 2 + 0.2 + 0.25, 1e-6);
    EXPECT_NEAR(whole.size()[1], 2 + 0.2, 1e-6);
    EXPECT_NEAR(whole.size()[2], 1.5 + 0.2, 1e-6);
    EXPECT_LT(whole.centre().norm(), 1e-6);
}

TEST(Copies, OfOneIsTheMeshItself)
{
    const TriMesh one = icosphere(1, 2);
    const TriMesh same = copies(one, {{1, 1, 1}, {5, 5, 5}, {1, 1, 1}, 90});
    EXPECT_EQ(same.positions, one.positions);
    EXPECT_EQ(same.triangles(), one.triangles());
    EXPECT_TRUE(copies({}, {}).positions.empty());
}

TEST(Copies, MayHaveGroupsOfTheirOwn)
{
    const TriMesh leg = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), {}, "leg");
    CopiesLayout layout{{2, 1, 1}, {2, 2, 2}, {0, 0, 0}, 0, true};
    const TriMesh legs = copies(leg, layout);
    EXPECT_EQ(legs.topology->groups, (std::vector<std::string>{"leg 1", "leg 2"}));
    EXPECT_EQ(legs.topology->group.front(), 0);
    EXPECT_EQ(legs.topology->group.back(), 1);
    const TriMesh bare = copies(icosphere(1, 1), layout);
    EXPECT_EQ(bare.topology->groups, (std::vector<std::string>{"1", "2"}));
    layout.number_groups = false;
    EXPECT_EQ(copies(leg, layout).topology->groups, std::vector<std::string>{"leg"});
}

TEST(Copies, HuesThatComeRoundAgainAreOneMaterial)
{
    const Material red{"red", linear_from_srgb(Vec3f(0.8f, 0.2f, 0.2f))};
    const TriMesh one = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), red, "");
    const TriMesh all = copies(one, {{6, 1, 1}, {2, 2, 2}, {0, 0, 0}, 120});
    ASSERT_EQ(all.topology->materials.size(), 3u);
    // 0.8, 0.2, 0.2 turned by a third of the circle: the largest share moves on.
    EXPECT_LT(
        (srgb_from_linear(all.topology->materials[1].colour) - Vec3f(0.2f, 0.8f, 0.2f)).norm(),
        1e-5f);
    EXPECT_LT(
        (srgb_from_linear(all.topology->materials[2].colour) - Vec3f(0.2f, 0.2f, 0.8f)).norm(),
        1e-5f);
}

TEST(Copies, TurnedHuesKeepGreyAndComeBack)
{
    EXPECT_EQ(turn_hue({0.3f, 0.3f, 0.3f}, 77), Vec3f(0.3f, 0.3f, 0.3f));
    const Vec3f c{0.1f, 0.5f, 0.35f};
    EXPECT_LT((turn_hue(turn_hue(c, 100), -100) - c).norm(), 1e-5f);
    // Yellow lies a sixth beyond red.
    const Vec3f yellow = turn_hue({1, 0, 0}, 60);
    EXPECT_LT((yellow - Vec3f(1, 1, 0)).norm(), 1e-5f);
}

TEST(Copies, SayWhatIsWrong)
{
    EXPECT_THROW(copies(icosphere(1, 0), {{0, 1, 1}, {1, 1, 1}, {0, 0, 0}, 0}),
                 std::invalid_argument);
    EXPECT_THROW(copies(icosphere(1, 0), {{100'000, 100'000, 100'000}, {1, 1, 1}, {0, 0, 0}, 0}),
                 std::invalid_argument);
}

}  // namespace
