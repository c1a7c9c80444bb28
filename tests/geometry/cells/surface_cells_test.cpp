#include "geometry/cells/surface_cells.hpp"

#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace {

using geometry::CellSet;
using geometry::CellShape;
using geometry::LatticeMesh;
using geometry::Random;
using geometry::Vec3;
using geometry::Vec3i;

// The definition, axis by axis, with nothing left out: 3 + 1 + 9 axes, all projections of all
// corners.
bool meets(const std::array<Vec3, 3>& p, const Vec3i& cell, CellShape shape)
{
    std::vector<Vec3> axes{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(),
                           (p[1] - p[0]).cross(p[2] - p[0])};
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t d = 0; d < 3; ++d) axes.push_back((p[(k + 1) % 3] - p[k]).cross(axes[d]));
    }
    for (const Vec3& axis : axes) {
        if (axis.isZero(0)) continue;
        double lo = 1e300, hi = -1e300, min = 1e300, max = -1e300;
        for (int a = 0; a < 8; ++a) {
            const Vec3i corner = cell + Vec3i(a & 1, a >> 1 & 1, a >> 2 & 1);
            const double s = axis.dot(corner.cast<double>());
            lo = std::min(lo, s), hi = std::max(hi, s);
        }
        for (const Vec3& v : p) min = std::min(min, axis.dot(v)), max = std::max(max, axis.dot(v));
        const bool half = shape == CellShape::half_open;
        // The cell's highest point along the axis is its own when no upper face is needed for it.
        const bool owns_hi = half && (axis.array() <= 0).all();
        const bool owns_lo = half && (axis.array() >= 0).all();
        if (min > hi || (min == hi && !owns_hi) || max < lo || (max == lo && !owns_lo)) {
            return false;
        }
    }
    return true;
}

std::vector<Vec3i> brute_cells(const LatticeMesh& mesh, CellShape shape)
{
    CellSet cells;
    for (const auto& [a, b, c] : mesh.triangles) {
        const std::array<Vec3, 3> p{mesh.positions[a], mesh.positions[b], mesh.positions[c]};
        const Vec3i lo = geometry::cell_of(p[0].cwiseMin(p[1]).cwiseMin(p[2])) - Vec3i::Ones();
        const Vec3i hi = geometry::cell_of(p[0].cwiseMax(p[1]).cwiseMax(p[2])) + Vec3i::Ones();
        for (int z = lo.z(); z <= hi.z(); ++z) {
            for (int y = lo.y(); y <= hi.y(); ++y) {
                for (int x = lo.x(); x <= hi.x(); ++x) {
                    if (meets(p, {x, y, z}, shape)) cells.insert({x, y, z});
                }
            }
        }
    }
    return cells.sorted();
}

// Random triangles whose corners lie on a lattice `steps` times as fine as the cells: with few
// steps, corners, sides and faces meet all the time, and all arithmetic is exact.
LatticeMesh lattice_soup(std::uint32_t count, double half, int steps, std::uint64_t seed)
{
    const Random random(seed);
    LatticeMesh mesh;
    for (std::uint32_t i = 0; i < 3 * count; ++i) {
        Vec3 p;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const double x = (2 * random.unit(3 * i + k) - 1) * half;
            p[static_cast<int>(k)] = steps > 0 ? std::round(x * steps) / steps : x;
        }
        mesh.positions.push_back(p);
        if (i % 3 == 2) mesh.triangles.push_back({i - 2, i - 1, i});
    }
    return mesh;
}

TEST(SurfaceCells, AreThoseThatNoAxisSeparates)
{
    for (const CellShape shape : {CellShape::half_open, CellShape::interior}) {
        for (const double half : {0.7, 1.5, 4.0, 9.0}) {
            for (std::uint64_t seed = 0; seed < 150; ++seed) {
                const LatticeMesh mesh = lattice_soup(1, half, 0, seed);
                ASSERT_EQ(surface_cells(mesh, shape).sorted(), brute_cells(mesh, shape))
                    << half << seed;
            }
        }
    }
}

TEST(SurfaceCells, AreThoseThatNoAxisSeparatesWhenEverythingTouches)
{
    // Small triangles are tested eight cells at a time, large ones by intervals: both.
    for (const auto& [half, seeds] : {std::pair(4.0, 150u), std::pair(8.0, 30u)}) {
        for (const CellShape shape : {CellShape::half_open, CellShape::interior}) {
            for (const int steps : {1, 2, 3, 4}) {
                for (std::uint64_t seed = 0; seed < seeds; ++seed) {
                    LatticeMesh mesh = lattice_soup(1, half, steps, seed);
                    if (steps == 3) {
                        for (Vec3& p : mesh.positions) p *= 3 / 4.0;  // quarters again, exact
                    }
                    ASSERT_EQ(surface_cells(mesh, shape).sorted(), brute_cells(mesh, shape))
                        << half << ' ' << steps << ' ' << seed;
                }
            }
        }
    }
}

TEST(SurfaceCells, NeverMissACellThatHoldsAPointOfATriangle)
{
    const Random random(77);
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const LatticeMesh mesh = lattice_soup(1, 5, seed % 2 ? 2 : 0, seed);
        const CellSet cells = surface_cells(mesh, CellShape::half_open);
        for (std::uint64_t i = 0; i < 400; ++i) {
            double u = random.unit(2 * i), v = random.unit(2 * i + 1);
            // Eighths, so that on lattices of halves the points are exact and often on faces.
            if (seed % 2) u = std::round(u * 8) / 8, v = std::round(v * 8) / 8;
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const Vec3 p = mesh.positions[0] + u * (mesh.positions[1] - mesh.positions[0]) +
                           v * (mesh.positions[2] - mesh.positions[0]);
            EXPECT_TRUE(cells.contains(geometry::cell_of(p))) << p.transpose();
        }
    }
}

TEST(SurfaceCells, SliversAndTrianglesWithoutAreaAreSegmentsAndPoints)
{
    for (std::uint64_t seed = 0; seed < 150; ++seed) {
        LatticeMesh mesh = lattice_soup(1, 6, 4, seed);
        auto& p = mesh.positions;
        if (seed % 3 == 0) p[2] = 0.5 * (p[0] + p[1]);
        if (seed % 3 == 1) p[2] = p[1];
        if (seed % 3 == 2) p[1] = p[2] = p[0];
        ASSERT_EQ(surface_cells(mesh, CellShape::half_open).sorted(),
                  brute_cells(mesh, CellShape::half_open))
            << seed;
        // A hair's breadth of area: the same but for cells that the hair alone decides.
        LatticeMesh hair = mesh;
        hair.positions[2] += Vec3(1e-12, -2e-12, 3e-12);
        const auto exact = brute_cells(hair, CellShape::half_open);
        const CellSet cells = surface_cells(hair, CellShape::half_open);
        for (int i = 0; i <= 64; ++i) {
            EXPECT_TRUE(cells.contains(
                geometry::cell_of(p[0] + (i + 0.3) / 65 * (hair.positions[1] - p[0]))));
        }
        EXPECT_LE(cells.count(), exact.size() + 8);
    }
}

TEST(SurfaceCells, ALargeTriangleAcrossManyCellsCostsItsRowsOnly)
{
    // A diagonal needle through 4096^3: its box holds 16 million rows, it meets some 12 thousand.
    LatticeMesh mesh;
    mesh.positions = {{0.1, 0.2, 0.3}, {4095.5, 4095.2, 4095.9}, {2000.1, 2000.7, 2000.2}};
    mesh.triangles = {{0, 1, 2}};
    const CellSet cells = surface_cells(mesh, CellShape::half_open);
    EXPECT_GT(cells.count(), 4096u);
    EXPECT_LT(cells.count(), 20000u);
    EXPECT_LT(cells.bytes(), 4u << 20);
}

TEST(SurfaceCells, AFaceThatLiesBetweenCubesBelongsToTheUpperOnes)
{
    LatticeMesh mesh;
    mesh.positions = {{0, 0, 2}, {3, 0, 2}, {3, 3, 2}, {0, 3, 2}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    const auto cells = surface_cells(mesh, CellShape::half_open).sorted();
    EXPECT_EQ(cells.size(), 16u);  // 0..3 squared: the far border too is a point of the square
    for (const Vec3i& c : cells) EXPECT_EQ(c.z(), 2);
    EXPECT_EQ(surface_cells(mesh, CellShape::interior).count(), 0u);
}

TEST(SurfaceCells, AreTheSameForAnyNumberOfThreads)
{
    const auto mesh = test_meshes::bumpy_sphere(5);
    geometry::VoxelGrid grid;
    grid.size = 0.02;
    const LatticeMesh lattice = to_lattice(mesh, grid);
    std::vector<Vec3i> reference;
    for (const unsigned threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const auto cells = surface_cells(lattice, CellShape::half_open).sorted();
        if (reference.empty()) reference = cells;
        EXPECT_EQ(cells, reference);
    }
    EXPECT_THROW(surface_cells(lattice, CellShape::half_open, 1000), geometry::TooManyCells);
}

}  // namespace
