#include "geometry/cubes/components.hpp"

#include "geometry/base/random.hpp"

#include <gtest/gtest.h>

#include <map>

namespace {

using geometry::Connectivity;
using geometry::Cubes;
using geometry::find_components;
using geometry::Vec3i;

Cubes random_cubes(int n, int half, std::uint64_t seed)
{
    const geometry::Random random(seed);
    std::vector<Vec3i> cells;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(n); ++i) {
        const auto at = [&](std::uint64_t k) {
            return static_cast<int>(random.unit(3 * i + k) * 2 * half) - half;
        };
        cells.emplace_back(at(0), at(1), at(2));
    }
    return geometry::solid_cubes(cells, 0.1);
}

// Flood fill from cube to cube over all pairs.
std::vector<std::uint32_t> brute_components(const Cubes& cubes, int allowed)
{
    std::vector<std::uint32_t> label(cubes.count(), ~0u);
    for (std::uint32_t seed = 0; seed < cubes.count(); ++seed) {
        if (label[seed] != ~0u) continue;
        std::vector<std::uint32_t> todo{seed};
        label[seed] = seed;
        while (!todo.empty()) {
            const auto c = todo.back();
            todo.pop_back();
            for (std::uint32_t d = 0; d < cubes.count(); ++d) {
                const Vec3i step = (cubes.cell[c] - cubes.cell[d]).cwiseAbs();
                if (label[d] == ~0u && step.maxCoeff() <= 1 && step.sum() <= allowed) {
                    label[d] = seed;
                    todo.push_back(d);
                }
            }
        }
    }
    return label;
}

TEST(Components, AreThoseThatAFloodFillFinds)
{
    for (const auto connectivity : {Connectivity::face, Connectivity::edge, Connectivity::corner}) {
        for (const int half : {4, 5, 7, 12}) {
            const Cubes cubes = random_cubes(300, half, static_cast<std::uint64_t>(half));
            const auto found = find_components(cubes, connectivity);
            const auto expected = brute_components(cubes, static_cast<int>(connectivity) + 1);
            std::map<std::uint32_t, std::uint32_t> names;
            for (std::size_t c = 0; c < cubes.count(); ++c) {
                const auto [at, added] = names.try_emplace(expected[c], found.label[c]);
                EXPECT_EQ(at->second, found.label[c]);
            }
            EXPECT_EQ(names.size(), found.count());
            std::vector<std::size_t> count(found.count(), 0);
            for (const auto l : found.label) ++count[l];
            EXPECT_EQ(count, found.cubes);
            EXPECT_TRUE(std::is_sorted(count.rbegin(), count.rend()));
        }
    }
}

TEST(Components, TheLargestByMassNeedNotHaveMostCubes)
{
    Cubes cubes = geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}, {5, 0, 0}}, 1);
    cubes.mass[2] = 1e6;
    EXPECT_EQ(find_components(cubes, Connectivity::face).label,
              (std::vector<std::uint32_t>{0, 0, 1}));
    const auto by_mass = find_components(cubes, Connectivity::face, geometry::Largest::by_mass);
    EXPECT_EQ(by_mass.label, (std::vector<std::uint32_t>{1, 1, 0}));
    EXPECT_EQ(by_mass.mass[0], 1e6);
    EXPECT_EQ(find_components({}, Connectivity::face).count(), 0u);
}

// Every cube twice, its copies side by side in the lists, and nothing of one glued to the other.
Cubes doubled(const Cubes& once)
{
    Cubes cubes = once;
    cubes.cell.clear(), cubes.corner.clear(), cubes.corners.clear();
    for (const Vec3i& c : once.cell) cubes.cell.insert(cubes.cell.end(), 2, c);
    for (const Vec3i& k : once.corner) cubes.corner.insert(cubes.corner.end(), 2, k);
    for (const auto& corners : once.corners) {
        for (std::uint32_t copy = 0; copy < 2; ++copy) {
            auto own = corners;
            for (auto& k : own) k = 2 * k + copy;
            cubes.corners.push_back(own);
        }
    }
    cubes.mass.assign(cubes.count(), 1.0);
    return cubes;
}

TEST(Components, CopiesOfACellHangTogetherByCornersOnly)
{
    for (const auto connectivity : {Connectivity::face, Connectivity::edge, Connectivity::corner}) {
        EXPECT_EQ(
            find_components(doubled(geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}}, 1)), connectivity)
                .label,
            (std::vector<std::uint32_t>{0, 1, 0, 1}));
        for (const int half : {4, 5, 7}) {
            const Cubes once = random_cubes(300, half, static_cast<std::uint64_t>(half));
            const auto expected = brute_components(once, static_cast<int>(connectivity) + 1);
            const auto found = find_components(doubled(once), connectivity);
            std::map<std::pair<std::uint32_t, std::size_t>, std::uint32_t> names;
            for (std::size_t c = 0; c < found.label.size(); ++c) {
                const auto [at, added] =
                    names.try_emplace({expected[c / 2], c % 2}, found.label[c]);
                EXPECT_EQ(at->second, found.label[c]);
            }
            EXPECT_EQ(names.size(), found.count());
        }
    }
}

TEST(Components, ThePairsOfCellsThatTouchInAnEdgeOrACorner)
{
    const Cubes edge = geometry::solid_cubes({{0, 0, 0}, {0, 1, 1}}, 1);
    EXPECT_EQ(find_components(edge, Connectivity::face).count(), 2u);
    EXPECT_EQ(find_components(edge, Connectivity::edge).count(), 1u);
    const Cubes corner = geometry::solid_cubes({{0, 0, 0}, {-1, 1, 1}}, 1);
    EXPECT_EQ(find_components(corner, Connectivity::edge).count(), 2u);
    EXPECT_EQ(find_components(corner, Connectivity::corner).count(), 1u);
}

TEST(Components, TheNearestCubeHoldsItsPoint)
{
    const Cubes cubes = random_cubes(200, 5, 1);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const auto found = nearest_cube(
            cubes, 0.1 * (cubes.cell[c].cast<double>() + geometry::Vec3(0.5, 0.2, 0.7)));
        EXPECT_EQ(found.cube, c);
        EXPECT_EQ(found.distance, 0);
    }
    EXPECT_NEAR(nearest_cube(geometry::solid_cubes({{0, 0, 0}}, 1), {2, 2, 0.5}).distance,
                std::sqrt(2.0), 1e-15);
}

}  // namespace
