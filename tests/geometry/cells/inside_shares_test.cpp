#include "geometry/cells/inside_shares.hpp"

#include "geometry/cells/cell_lines.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <bit>

namespace {

using geometry::Inside;
using geometry::InsideShares;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using geometry::Vec3i;
using geometry::VoxelGrid;
using test_meshes::both;
using test_meshes::box;

TriMesh without(const TriMesh& mesh, std::size_t first, std::size_t count)
{
    auto triangles = mesh.triangles();
    const auto from = triangles.begin() + static_cast<std::ptrdiff_t>(first);
    triangles.erase(from, from + static_cast<std::ptrdiff_t>(count));
    return test_meshes::mesh_of(mesh.positions, triangles);
}

// Cubes of 1 m without bounds: lattice coordinates are metres, to a millionth.
InsideShares shares_of(const TriMesh& mesh, Inside rule = Inside::winding)
{
    return inside_shares(to_lattice(mesh, VoxelGrid{}), rule);
}

// m^3 of what an axis-aligned box and a cell share.
double overlap(const Vec3& lo, const Vec3& hi, const Vec3i& cell)
{
    const Vec3 at = cell.cast<double>();
    return (hi.cwiseMin(at + Vec3::Ones()) - lo.cwiseMax(at)).cwiseMax(0).prod();
}

struct Case {
    const char* name;
    Vec3 lo, hi;
};

// Boards and rods of chairs, thinner and thicker than what 4 x 4 x 4 points can tell.
const Case boxes[]{{"board between points", {0.1, 2.14, 0.2}, {5.3, 2.36, 4.7}},
                   {"board over points", {0.1, 2.36, 0.2}, {5.3, 2.4, 4.7}},
                   {"board across cells", {0.1, 1.9, 0.2}, {5.3, 2.05, 4.7}},
                   {"rod along x", {-3.3, 0.4, 0.6}, {4.2, 0.5, 0.7}},
                   {"rod along y", {0.4, -3.3, 0.6}, {0.5, 4.2, 0.7}},
                   {"rod along z", {0.4, 0.6, -3.3}, {0.5, 0.7, 4.2}},
                   {"crumb", {0.45, 0.45, 0.45}, {0.55, 0.55, 0.55}},
                   {"block", {0.3, -1.2, 0.7}, {4.6, 2.9, 3.1}}};

TEST(InsideShares, OfBoxesAreExact)
{
    for (const Case& c : boxes) {
        for (const TriMesh& mesh : {box(c.lo, c.hi), test_meshes::inside_out(box(c.lo, c.hi))}) {
            for (const Inside rule : {Inside::winding, Inside::parity}) {
                const InsideShares border = shares_of(mesh, rule);
                ASSERT_FALSE(border.cells.empty());
                for (std::size_t i = 0; i < border.cells.size(); ++i) {
                    EXPECT_NEAR(border.share[i], overlap(c.lo, c.hi, border.cells[i]), 2e-6)
                        << c.name << " at " << border.cells[i].transpose();
                }
            }
        }
    }
}

// Without a face the rows through it are open; the other two axes know.
TEST(InsideShares, OfABoxWithoutAFaceAreExact)
{
    for (const Case& c : boxes) {
        for (const unsigned face : {0u, 2u, 4u, 6u, 8u, 10u}) {
            const InsideShares border = shares_of(without(box(c.lo, c.hi), face, 2));
            for (std::size_t i = 0; i < border.cells.size(); ++i) {
                EXPECT_NEAR(border.share[i], overlap(c.lo, c.hi, border.cells[i]), 2e-6)
                    << c.name << " without " << face;
            }
        }
    }
}

TEST(InsideShares, OfAnythingClosedAddUpToItsVolume)
{
    const geometry::Random random(7);
    for (std::uint32_t i = 0; i < 20; ++i) {
        TriMesh mesh = i % 2 ? test_meshes::bumpy_sphere(3)
                             : box({-1, -0.04 * (i + 1), -0.03 * (i + 1)},
                                   {1, 0.04 * (i + 1), 0.03 * (i + 1)});
        const Eigen::Quaterniond turn(
            Eigen::Vector4d(random.unit(4 * i) - 0.5, random.unit(4 * i + 1) - 0.5,
                            random.unit(4 * i + 2) - 0.5, random.unit(4 * i + 3) - 0.5)
                .normalized());
        for (Vec3f& p : mesh.positions) {
            p = (turn * (3.3 * p.cast<double>()) + Vec3(0.1, 0.2, 0.3)).cast<float>();
        }
        const geometry::LatticeMesh lattice = to_lattice(mesh, VoxelGrid{});
        double volume = 0;  // the divergence theorem over the polyhedron
        for (const auto& [a, b, c] : lattice.triangles) {
            const Vec3 &p = lattice.positions[a], &q = lattice.positions[b];
            volume += p.dot(q.cross(lattice.positions[c])) / 6;
        }
        const InsideShares border = inside_shares(lattice, Inside::winding);
        const geometry::CellSet cells = solid_cells(lattice, Inside::winding);
        double sum = double(cells.count());
        for (std::size_t k = 0; k < border.cells.size(); ++k) {
            EXPECT_GE(border.share[k], 0);
            EXPECT_LE(border.share[k], 1);
            if (cells.contains(border.cells[k])) sum += border.share[k] - 1;
        }
        EXPECT_NEAR(sum, volume, 1e-10 * volume) << i;
    }
}

// What the columns would count twice, or less the other, is left to points.
TEST(InsideShares, WherePiecesOverlapArePoints)
{
    const TriMesh one = box({0.2, 0.2, 0.2}, {2.7, 2.7, 2.7}),
                  other = box({1.3, 1.3, 1.3}, {3.7, 3.7, 3.7});
    struct Pair {
        const char* name;
        TriMesh mesh;
        int sign;  // of the other's winding
    };
    for (const auto& [name, mesh, sign] :
         {Pair{"twice the same", both(one, one), 0}, Pair{"crossing", both(one, other), 1},
          Pair{"hollowed", both(one, test_meshes::inside_out(other)), -1}}) {
        const geometry::LatticeMesh lattice = to_lattice(mesh, VoxelGrid{});
        const InsideShares border = inside_shares(lattice, Inside::winding);
        const auto inside = cell_lines(lattice, Inside::winding, border.cells).inside;
        std::size_t points = 0;
        for (std::size_t i = 0; i < border.cells.size(); ++i) {
            const Vec3i& cell = border.cells[i];
            const double in_one = overlap(Vec3::Constant(0.2), Vec3::Constant(2.7), cell);
            const double in_other = overlap(Vec3::Constant(1.3), Vec3::Constant(3.7), cell);
            const double in_both = overlap(Vec3::Constant(1.3), Vec3::Constant(2.7), cell);
            if (sign > 0 ? in_both == 0 : sign < 0 && (in_one == in_both || in_other == in_both)) {
                EXPECT_NEAR(border.share[i], std::abs(in_one + sign * in_other), 2e-6)
                    << name << " at " << cell.transpose();
            } else if (in_one > 0 || in_other > 0) {
                EXPECT_EQ(border.share[i], std::popcount(inside[i]) / 64.0)
                    << name << " at " << cell.transpose();
                ++points;
            }
        }
        EXPECT_GT(points, 5u) << name;
    }
}

// Two axes whose rows are open say the same, and both wrong.
TEST(InsideShares, OpenRowsDoNotCount)
{
    const TriMesh open = without(box(Vec3::Constant(0.2), Vec3::Constant(2.7)), 6, 2);   // y
    const geometry::LatticeMesh lattice = to_lattice(without(open, 2, 2), VoxelGrid{});  // z
    const InsideShares border = inside_shares(lattice, Inside::winding);
    const auto inside = cell_lines(lattice, Inside::winding, border.cells).inside;
    for (std::size_t i = 0; i < border.cells.size(); ++i) {
        const double exact = overlap(Vec3::Constant(0.2), Vec3::Constant(2.7), border.cells[i]);
        if (std::abs(border.share[i] - exact) > 2e-6) {
            EXPECT_EQ(border.share[i], std::popcount(inside[i]) / 64.0);
            EXPECT_NEAR(border.share[i], exact, 0.15);
        }
    }
}

// No line along x meets it; those across it see both of its copies.
TEST(InsideShares, ABoardNamedTwiceIsNotTwiceAsThick)
{
    const TriMesh board = box({0.2, 2.14, 0.2}, {5.3, 2.36, 4.7});
    for (const double share : shares_of(both(board, board)).share) EXPECT_EQ(share, 0);

    TriMesh lens = test_meshes::icosphere(5);  // of small triangles; its rim is thin
    for (Vec3f& p : lens.positions) p = {4 * p.x(), 2.25f + 0.1f * p.y(), 4 * p.z()};
    const InsideShares once = shares_of(lens), twice = shares_of(both(lens, lens));
    std::size_t zeros = 0;
    for (std::size_t i = 0; i < once.cells.size(); ++i) {
        if (2 * once.share[i] <= 0.04) continue;
        EXPECT_EQ(twice.share[i], 0) << once.cells[i].transpose();
        ++zeros;
    }
    EXPECT_GT(zeros, 40u);
}

// Two boards one on the other, exactly or but for rounding, are as one.
TEST(InsideShares, BoardsThatTouchDoNotOverlap)
{
    const Vec3 lo(0.2, 2.14, 0.2), hi(5.3, 2.36, 4.7);
    const TriMesh board = box(lo, {hi.x(), 2.25, hi.z()});
    for (const double seam : {2.25, 2.25 - 1e-4, 2.25 + 1e-4}) {
        const TriMesh two = both(board, box({lo.x(), seam, lo.z()}, hi));
        for (const TriMesh& mesh : {two, test_meshes::inside_out(two)}) {
            const InsideShares border = shares_of(mesh);
            for (std::size_t i = 0; i < border.cells.size(); ++i) {
                EXPECT_NEAR(border.share[i], overlap(lo, hi, border.cells[i]), 1.1e-4);
            }
        }
    }
}

TEST(InsideShares, TakeWhateverComesAndTheSameOnAnyNumberOfThreads)
{
    EXPECT_TRUE(inside_shares({}, Inside::winding).cells.empty());
    const TriMesh soup = both(test_meshes::random_soup(3000, 3, 9), test_meshes::icosphere(6));
    for (const Inside rule : {Inside::winding, Inside::parity}) {
        std::vector<double> shares;
        for (const unsigned threads : {1u, 2u, 8u}) {
            const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
            const InsideShares border = shares_of(soup, rule);
            for (const double share : border.share) {
                EXPECT_GE(share, 0);
                EXPECT_LE(share, 1);
            }
            if (shares.empty()) shares = border.share;
            EXPECT_EQ(shares, border.share);
        }
    }
}

}  // namespace
