#include "geometry/embed/parted_cubes.hpp"

#include "geometry/cubes/plane.hpp"
#include "tests/geometry/embed/torn_blocks.hpp"

#include <gtest/gtest.h>

using namespace geometry;
using namespace torn_blocks;

TEST(FindParted, CountsWhatTheLinksOfACubeLeaveJoined)
{
    const Cubes cubes = block({3, 2, 2}, 0.5, Vec3(1, 2, 3));
    EXPECT_TRUE(find_parted(cubes, {}).empty());
    // One link less, or all around one edge: each cube still joins the ends another way.
    const std::uint32_t first = cubes.corners[0][0];
    EXPECT_TRUE(find_parted(cubes, std::vector{3 * first}).empty());
    // A corner of the block that has lost its three links is a part of its own.
    const auto lone = find_parted(cubes, std::vector{3 * first, 3 * first + 1, 3 * first + 2});
    ASSERT_EQ(lone.size(), 1u);
    EXPECT_EQ(lone[0].cube, 0u);
    EXPECT_EQ(lone[0].parts, 2);
    EXPECT_EQ(lone[0].part, (std::array<std::uint8_t, 8>{0, 1, 1, 1, 1, 1, 1, 1}));
    // All cubes of a slice are in halves.
    const auto slice = find_parted(cubes, links_across(cubes, 0, 1));
    ASSERT_EQ(slice.size(), 4u);
    for (const PartedCube& p : slice) {
        EXPECT_EQ(cubes.cell[p.cube].x(), 1);
        EXPECT_EQ(p.part, (std::array<std::uint8_t, 8>{0, 1, 0, 1, 0, 1, 0, 1}));
    }
    // Every link gone: eight parts each.
    const auto dust =
        find_parted(cubes, links_between(cubes, [](const Vec3i&, const Vec3i&) { return true; }));
    ASSERT_EQ(dust.size(), cubes.count());
    for (const PartedCube& p : dust) EXPECT_EQ(p.parts, 8);
    const auto all = marked(cubes, slice);
    EXPECT_EQ(std::count(all.begin(), all.end(), 1), 4);
    EXPECT_EQ(all[slice[2].cube], 1);
}

TEST(FindParted, OfAPlaneKnowsNoThickness)
{
    const Cubes cubes = plane_cubes(rectangle_cells(3, 2), {1, 0.25, Vec3::Zero()}, 0.01);
    const auto parted = find_parted(cubes, links_across(cubes, 2, 1));
    ASSERT_EQ(parted.size(), 3u);
    for (const PartedCube& p : parted) {
        EXPECT_EQ(cubes.cell[p.cube].z(), 1);
        EXPECT_EQ(p.parts, 2);
        EXPECT_EQ(p.part, (std::array<std::uint8_t, 8>{0, 0, 0, 0, 1, 1, 1, 1}));
    }
}

TEST(FindParted, OfCubesThatShareACellIsTheFirst)
{
    Cubes cubes = solid_cubes({{0, 0, 0}}, 1);  // and a copy of it, linked to nothing
    cubes.cell.push_back(cubes.cell[0]);
    cubes.corners.push_back(cubes.corners[0]);
    for (auto& k : cubes.corners[1]) k += 8;
    for (std::size_t k = 0; k < 8; ++k) cubes.corner.push_back(cubes.corner[k]);
    const auto lone = [&](std::uint32_t k) {
        return find_parted(cubes, std::vector{3 * k, 3 * k + 1, 3 * k + 2});
    };
    EXPECT_EQ(lone(0).size(), 1u);
    EXPECT_TRUE(lone(8).empty());
}
