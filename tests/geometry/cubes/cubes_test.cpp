#include "geometry/cubes/cubes.hpp"

#include "geometry/base/random.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace {

using geometry::Cubes;
using geometry::Vec3i;

std::vector<Vec3i> random_cells(int n, int half, std::uint64_t seed)
{
    const geometry::Random random(seed);
    std::vector<Vec3i> cells;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(n); ++i) {
        const auto at = [&](std::uint64_t k) {
            return static_cast<int>(random.unit(3 * i + k) * 2 * half) - half;
        };
        cells.emplace_back(at(0), at(1), at(2));
    }
    return cells;
}

TEST(Cubes, CornersAreSharedSortedAndWhereTheirCubesSay)
{
    for (const int half : {1, 3, 6, 40}) {
        const Cubes cubes = geometry::solid_cubes(random_cells(400, half, 3), 0.5);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            for (int a = 0; a < 8; ++a) {
                const Vec3i expected = cubes.cell[c] + Vec3i(a & 1, a >> 1 & 1, a >> 2 & 1);
                const auto k = cubes.corners[c][static_cast<std::size_t>(a)];
                ASSERT_LT(k, cubes.corner_count());
                EXPECT_EQ(cubes.corner[k], expected);
            }
        }
        std::vector<std::uint8_t> used(cubes.corner_count(), 0);
        for (const auto& corners : cubes.corners) {
            for (const auto k : corners) used[k] = 1;
        }
        EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0);
        for (std::size_t k = 1; k < cubes.corner_count(); ++k) {  // sorted, hence none twice
            const Vec3i &p = cubes.corner[k - 1], &q = cubes.corner[k];
            EXPECT_LT(std::tuple(p.z(), p.y(), p.x()), std::tuple(q.z(), q.y(), q.x()));
        }
    }
}

TEST(Cubes, ABlockHasTheCornersOfItsLattice)
{
    std::vector<Vec3i> cells;
    for (int i = 0; i < 60; ++i) cells.emplace_back(i % 3, i / 3 % 4, i / 12);
    const Cubes cubes = geometry::solid_cubes(cells, 0.1, {.density = 2000});
    EXPECT_EQ(cubes.count(), 60u);
    EXPECT_EQ(cubes.corner_count(), 4u * 5 * 6);
    const auto masses = geometry::corner_masses(cubes);
    // 60 cubes of a litre at two tonnes a cubic metre.
    EXPECT_NEAR(std::accumulate(masses.begin(), masses.end(), 0.0), 120, 1e-12 * 120);
    EXPECT_EQ(geometry::solid_cubes({}, 1).corner_count(), 0u);
}

TEST(Cubes, WhatIsKeptKeepsItsOrderAndItsCorners)
{
    const Cubes cubes = geometry::solid_cubes(random_cells(500, 5, 4), 0.5);
    std::vector<std::uint8_t> keep(cubes.count());
    for (std::size_t c = 0; c < keep.size(); ++c) keep[c] = c % 3 == 0;
    const Cubes some = geometry::kept(cubes, keep);
    std::vector<Vec3i> cells;
    for (std::size_t c = 0; c < keep.size(); c += 3) cells.push_back(cubes.cell[c]);
    const Cubes expected = geometry::solid_cubes(cells, 0.5);
    EXPECT_EQ(some.cell, expected.cell);
    EXPECT_EQ(some.corner, expected.corner);
    EXPECT_EQ(some.corners, expected.corners);
    EXPECT_EQ(some.mass, expected.mass);
    EXPECT_TRUE(some.component.empty());
}

}  // namespace
