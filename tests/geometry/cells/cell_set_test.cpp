#include "geometry/cells/cell_set.hpp"

#include "geometry/base/random.hpp"

#include <gtest/gtest.h>

#include <set>

namespace {

using geometry::CellIndex;
using geometry::CellSet;
using geometry::Vec3i;

auto key(const Vec3i& c)
{
    return std::tuple(c.z(), c.y(), c.x());
}
struct Before {
    bool operator()(const Vec3i& a, const Vec3i& b) const { return key(a) < key(b); }
};

Vec3i random_cell(const geometry::Random& random, std::uint64_t i, int half)
{
    const auto at = [&](std::uint64_t k) {
        return static_cast<int>(std::floor((2 * random.unit(3 * i + k) - 1) * half));
    };
    return {at(0), at(1), at(2)};
}

TEST(CellSet, HoldsWhatAnOrderedSetHolds)
{
    for (const int half : {3, 40, 1000, CellSet::extent}) {
        CellSet cells;
        std::set<Vec3i, Before> expected;
        const geometry::Random random(5);
        for (std::uint64_t i = 0; i < 3000; ++i) {
            const Vec3i c = random_cell(random, i, half);
            const int end = std::min(c.x() + static_cast<int>(i % 30), CellSet::extent - 1);
            cells.insert_run(c.x(), end, c.y(), c.z());
            for (int x = c.x(); x <= end; ++x) expected.insert({x, c.y(), c.z()});
        }
        EXPECT_EQ(cells.count(), expected.size());
        EXPECT_EQ(cells.sorted(), std::vector<Vec3i>(expected.begin(), expected.end()));
        for (std::uint64_t i = 0; i < 3000; ++i) {
            const Vec3i c = random_cell(random, i + 1500, half);
            EXPECT_EQ(cells.contains(c), expected.contains(c));
        }
    }
}

TEST(CellSet, UnitesWithAnother)
{
    CellSet a, b;
    a.insert_run(-3, 20, 5, -9);
    b.insert_run(10, 40, 5, -9);
    b.insert({7, 7, 7});
    a.unite(b);
    EXPECT_EQ(a.count(), 45u);  // -3 .. 40, and one more
    EXPECT_TRUE(a.contains({40, 5, -9}));
    EXPECT_TRUE(a.contains({7, 7, 7}));
}

TEST(CellSet, StopsAtItsLimit)
{
    CellSet cells(100);
    cells.insert_run(0, 99, 0, 0);
    cells.insert_run(0, 99, 0, 0);  // nothing new
    EXPECT_THROW(cells.insert({0, 1, 0}), geometry::TooManyCells);
}

TEST(CellSet, MemoryFollowsTheCellsNotTheBoxAroundThem)
{
    // A diagonal of single cells across the whole extent: the dearest case, a tile of 2 kB for
    // every 64 cells and a block of 72 bytes for every 8.
    CellSet cells;
    for (int i = -100000; i < 100000; ++i) cells.insert({i, i, i});
    EXPECT_LT(cells.bytes(), 200000u * 120u);  // vectors may have grown to twice their need
}

TEST(CellIndex, FindsEveryCellAndNoOther)
{
    const geometry::Random random(8);
    std::set<Vec3i, Before> expected;
    for (std::uint64_t i = 0; i < 5000; ++i) expected.insert(random_cell(random, i, 12));
    const std::vector<Vec3i> cells(expected.begin(), expected.end());
    const CellIndex index(cells);
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
        EXPECT_EQ(index.find(cells[i]).begin, i);
        EXPECT_EQ(index.find(cells[i]).end, i + 1);
    }
    for (std::uint64_t i = 0; i < 5000; ++i) {
        const Vec3i c = random_cell(random, i + 7777, 14);
        EXPECT_EQ(static_cast<bool>(index.find(c)), expected.contains(c));
    }
    EXPECT_FALSE(index.find({1 << 30, 0, 0}));
    EXPECT_FALSE(CellIndex{}.find({0, 0, 0}));
}

TEST(CellIndex, GivesAllCopiesOfACell)
{
    const std::vector<Vec3i> cells{{0, 0, 0}, {1, 0, 0}, {1, 0, 0},
                                   {1, 0, 0}, {5, 0, 0}, {0, 1, 0}};
    const CellIndex index(cells);
    EXPECT_EQ(index.find({1, 0, 0}).begin, 1u);
    EXPECT_EQ(index.find({1, 0, 0}).end, 4u);
    EXPECT_EQ(index.find({5, 0, 0}).begin, 4u);
    EXPECT_EQ(index.find({0, 1, 0}).end, 6u);
    EXPECT_FALSE(index.find({2, 0, 0}));
}

TEST(CellRuns, AreTheCellsInOrder)
{
    const std::vector<Vec3i> cells{{0, 0, 0}, {1, 0, 0}, {3, 0, 0},
                                   {4, 1, 0}, {5, 1, 0}, {5, 1, 1}};
    const auto rows = geometry::runs_of(cells);
    ASSERT_EQ(rows.runs.size(), 4u);
    ASSERT_EQ(rows.rows.size(), 4u);
    std::vector<Vec3i> back;
    for (std::size_t r = 0; r + 1 < rows.rows.size(); ++r) {
        for (auto k = rows.rows[r].first; k < rows.rows[r + 1].first; ++k) {
            EXPECT_EQ(rows.runs[k].first, back.size());
            for (int x = rows.runs[k].x0; x < rows.runs[k].x1; ++x) {
                back.push_back({x, rows.rows[r].y, rows.rows[r].z});
            }
        }
    }
    EXPECT_EQ(back, cells);
    EXPECT_TRUE(geometry::runs_of({}).runs.empty());
}

}  // namespace
