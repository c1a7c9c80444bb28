#include "geometry/cells/solid_cells.hpp"

#include "geometry/cells/cell_lines.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace {

using geometry::CellSet;
using geometry::CellShape;
using geometry::Inside;
using geometry::LatticeMesh;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3i;
using geometry::VoxelGrid;

VoxelGrid grid_across(const TriMesh& mesh, int resolution)
{
    const auto box = triangle_bounds(mesh);
    return fit_grid(box, size_for(box, resolution));
}

// Six rays from near a point, cast one by one: the rule in the words of Inside.
bool inside_by_rays(const LatticeMesh& mesh, Inside rule, const Vec3& point)
{
    const geometry::LineOffset off = line_offset(mesh);
    int votes = 0;
    for (int ray = 0; ray < 6; ++ray) {
        const int u = ray / 2, v = (u + 1) % 3, w = (u + 2) % 3;
        Vec3 p = point;
        p[v] += off.v, p[w] += off.w;
        const double way = ray % 2 ? 1 : -1;
        int sum = 0, count = 0;
        for (const auto& [a, b, c] : mesh.triangles) {
            const Vec3 q[3] = {mesh.positions[a] - p, mesh.positions[b] - p, mesh.positions[c] - p};
            const auto area = [&](int i, int j) { return q[i][v] * q[j][w] - q[i][w] * q[j][v]; };
            const double A = area(1, 2), B = area(2, 0), C = area(0, 1), all = A + B + C;
            if ((A > 0) != (B > 0) || (B > 0) != (C > 0)) continue;
            const double at = (A * q[0][u] + B * q[1][u] + C * q[2][u]) / all;
            if (at * way < 0) continue;
            sum += all * way > 0 ? 1 : -1;  // it leaves where the normal goes its way
            ++count;
        }
        votes += rule == Inside::parity ? count % 2 : (sum > 0) - (sum < 0);
    }
    return std::abs(votes) > 3;
}

std::vector<Vec3i> cells_of(const VoxelGrid& grid)
{
    std::vector<Vec3i> cells;
    for (int z = 0; z < grid.cells.z(); ++z) {
        for (int y = 0; y < grid.cells.y(); ++y) {
            for (int x = 0; x < grid.cells.x(); ++x) cells.emplace_back(x, y, z);
        }
    }
    return cells;
}

// Open, torn and crossing meshes, where the rays disagree.
TEST(SolidCells, AreWhereMostOfSixRaysSaySo)
{
    const TriMesh ball = test_meshes::icosphere(2);
    const geometry::Random random(5);
    std::vector<geometry::Triangle> torn;  // a fifth is missing, a fifth is turned over
    for (std::uint32_t t = 0; t < ball.triangles().size(); ++t) {
        auto [a, b, c] = ball.triangles()[t];
        const double chance = random.unit(t);
        if (chance < 0.2) continue;
        if (chance < 0.4) std::swap(b, c);
        torn.push_back({a, b, c});
    }
    const TriMesh soup = test_meshes::random_soup(12, 8, 2.5);
    for (const TriMesh& mesh :
         {test_meshes::mesh_of(ball.positions, torn), soup, test_meshes::both(ball, soup)}) {
        const VoxelGrid grid = grid_across(mesh, 12);
        LatticeMesh lattice = to_lattice(mesh, grid);
        lattice.closed = false;
        const std::vector<Vec3i> cells = cells_of(grid);
        const CellSet surface = surface_cells(lattice, CellShape::interior);
        for (const Inside rule : {Inside::winding, Inside::parity}) {
            const CellSet solid = solid_cells(lattice, rule);
            const auto points = cell_lines(lattice, rule, cells).inside;
            const Vec3 half = Vec3::Constant(0.5);
            std::size_t in = 0, wrong = 0;
            for (std::size_t i = 0; i < cells.size(); ++i) {
                const Vec3 at = cells[i].cast<double>();
                EXPECT_EQ(solid.contains(cells[i]),
                          surface.contains(cells[i]) || inside_by_rays(lattice, rule, at + half))
                    << at.transpose();
                for (std::size_t k = i % 7; k < 64; k += 7) {
                    const Vec3 fine = Vec3(double(k % 4), double(k / 4 % 4), double(k >> 4)) + half;
                    const bool inside = inside_by_rays(lattice, rule, at + fine / 4);
                    wrong += inside != ((points[i] >> k & 1) != 0);
                    in += inside;
                }
            }
            EXPECT_EQ(wrong, 0u);
            EXPECT_GT(in, 300u) << "there is something to be wrong about";
        }
    }
}

// Faces whose edges pass through the middle of rows as nearly as numbers say: a row that both
// faces, or neither, took for theirs would be counted twice or lost.
TEST(SolidCells, NoRowIsLostBetweenFaces)
{
    // A slab across x, its two sides fans around a hub: all corners over middles of cells.
    constexpr int wide = 98, high = 98;  // 49 (k / 49) is often not k
    std::vector<geometry::Vec3f> p{{2.3f, 49.5f, 49.5f}, {7.6f, 49.5f, 49.5f}};
    const auto add = [&](int y, int z) {
        for (const float x : {2.3f, 7.6f}) p.emplace_back(x, float(y) + 0.5f, float(z) + 0.5f);
    };
    for (int y = 0; y < wide; ++y) add(y, 0);
    for (int z = 0; z < high; ++z) add(wide, z);
    for (int y = wide; y > 0; --y) add(y, high);
    for (int z = high; z > 0; --z) add(0, z);
    std::vector<geometry::Triangle> t;
    const auto n = static_cast<std::uint32_t>(p.size());
    for (std::uint32_t i = 2; i < n; i += 2) {
        const std::uint32_t j = i + 2 < n ? i + 2 : 2;
        t.insert(t.end(), {{0, j, i}, {1, i + 1, j + 1}, {i, j, j + 1}, {i, j + 1, i + 1}});
    }
    for (const auto& mesh :
         {test_meshes::mesh_of(p, t), test_meshes::inside_out(test_meshes::mesh_of(p, t))}) {
        const CellSet cells = solid_cells(to_lattice(mesh, VoxelGrid{}), Inside::winding);
        for (int y = 1; y < wide; ++y) {
            for (int z = 1; z < high; ++z) {
                for (int x = 0; x < 10; ++x) {
                    EXPECT_EQ(cells.contains({x, y, z}), x >= 2 && x <= 7)
                        << Vec3i(x, y, z).transpose();
                }
            }
        }
    }
}

TEST(SolidCells, AreTheSurfaceAndEveryCentreWithAWindingNumber)
{
    using test_meshes::both;
    const TriMesh ball = test_meshes::bumpy_sphere(3);
    TriMesh moved = test_meshes::icosphere(2);
    for (auto& p : moved.positions) p = 0.8f * p + geometry::Vec3f(0.7f, 0.3f, -0.2f);
    TriMesh hole = test_meshes::inside_out(test_meshes::icosphere(2));
    for (auto& p : hole.positions) p *= 0.4f;
    for (const TriMesh& mesh : {ball, test_meshes::inside_out(ball), both(ball, ball),
                                both(ball, moved), both(ball, hole)}) {
        const VoxelGrid grid = grid_across(mesh, 16);
        const LatticeMesh lattice = to_lattice(mesh, grid);
        const CellSet cells = solid_cells(lattice, Inside::winding);
        const CellSet surface = surface_cells(lattice, CellShape::interior);
        const geometry::TriangleBvh bvh(mesh);
        for (const Vec3i& c : cells_of(grid)) {
            const Vec3 centre = grid.origin + grid.size * (c.cast<double>() + Vec3::Constant(0.5));
            EXPECT_EQ(cells.contains(c), surface.contains(c) || bvh.inside(centre))
                << c.transpose();
        }
    }
}

TEST(SolidCells, ParityNeedsNoOrientation)
{
    // Every second face turned over: hopeless for winding, nothing to parity.
    const TriMesh ball = test_meshes::bumpy_sphere(3);
    auto triangles = ball.triangles();
    for (std::size_t t = 0; t < triangles.size(); t += 2)
        std::swap(triangles[t][1], triangles[t][2]);
    const TriMesh mixed = test_meshes::mesh_of(ball.positions, triangles);
    const VoxelGrid grid = grid_across(ball, 30);
    EXPECT_EQ(solid_cells(to_lattice(mixed, grid), Inside::parity).sorted(),
              solid_cells(to_lattice(ball, grid), Inside::winding).sorted());
}

TEST(SolidCells, AHoleDoesNotEmptyTheSolid)
{
    // A ball without the cap above y = 0.8: from most of the inside, at most one ray of six is
    // lost.
    const TriMesh ball = test_meshes::icosphere(4);
    std::vector<geometry::Triangle> kept;
    for (const auto& t : ball.triangles()) {
        if (ball.positions[t[0]].y() < 0.8f) kept.push_back(t);
    }
    const TriMesh open = test_meshes::mesh_of(ball.positions, kept);
    VoxelGrid grid = grid_across(ball, 40);
    for (const Inside rule : {Inside::winding, Inside::parity}) {
        const CellSet cells = solid_cells(to_lattice(open, grid), rule);
        for (const Vec3i& c : cells_of(grid)) {
            const Vec3 centre = grid.origin + grid.size * (c.cast<double>() + Vec3::Constant(0.5));
            if (centre.norm() < 0.94 && centre.y() < 0.7) {
                EXPECT_TRUE(cells.contains(c));
            }
            if (centre.norm() > 1.06) {
                EXPECT_FALSE(cells.contains(c)) << centre.transpose();
            }
        }
    }
}

// A box of two halves with a slit across x between them, each without its face there.
TriMesh box_of_halves(double slit)
{
    const TriMesh box = test_meshes::box({0, 0, 0}, {1, 1, 1});
    std::vector<geometry::Triangle> triangles;
    std::vector<geometry::Vec3f> positions;
    for (const bool left : {true, false}) {
        const auto first = static_cast<std::uint32_t>(positions.size());
        const auto outer = [&](std::uint32_t v) { return (box.positions[v].x() < 0.5f) == left; };
        for (std::uint32_t v = 0; v < box.positions.size(); ++v) {
            geometry::Vec3f p = box.positions[v];
            if (!outer(v)) p.x() = static_cast<float>(0.5 + (left ? -0.5 : 0.5) * slit);
            positions.push_back(p);
        }
        for (const auto& [a, b, c] : box.triangles()) {
            if (!outer(a) && !outer(b) && !outer(c)) continue;
            triangles.push_back({first + a, first + b, first + c});
        }
    }
    return test_meshes::mesh_of(positions, triangles);
}

// The middles of an odd number of cells lie in the slit, so that rays from there along both axes
// in it would pass between all faces.
TEST(SolidCells, ASlitBetweenMirroredHalvesLosesNothing)
{
    for (const double slit : {1e-5, 1e-3, 4e-3}) {  // up to a twelfth of a cell
        const TriMesh halves = box_of_halves(slit);
        ASSERT_EQ(halves.triangles().size(), 20u);
        for (const int across : {8, 9, 11, 21}) {
            const VoxelGrid grid = grid_across(halves, across);
            const LatticeMesh lattice = to_lattice(halves, grid);
            const std::vector<Vec3i> all = cells_of(grid);
            for (const Inside rule : {Inside::winding, Inside::parity}) {
                EXPECT_EQ(solid_cells(lattice, rule).count(), all.size()) << across << ", " << slit;
                for (const std::uint64_t inside : cell_lines(lattice, rule, all).inside) {
                    EXPECT_EQ(inside, ~std::uint64_t{0}) << across << ", " << slit;
                }
            }
        }
    }
}

TEST(SolidCells, AnAlignedBoxIsExactlyItsCubes)
{
    // Between other cubes, so that no face is at the grid's end.
    const TriMesh mesh = test_meshes::box({0.2, 0.3, 0.1}, {0.7, 0.5, 0.4});
    VoxelGrid grid;
    grid.size = 0.1;
    const LatticeMesh lattice = to_lattice(mesh, grid);
    const auto cells = solid_cells(lattice, Inside::winding).sorted();
    EXPECT_EQ(cells.size(), 5u * 2 * 3);
    for (const std::uint64_t inside : cell_lines(lattice, Inside::winding, cells).inside) {
        EXPECT_EQ(inside, ~std::uint64_t{0});
    }
    // A sheet on a face between cells has no inside but is not lost.
    const TriMesh sheet = test_meshes::mesh_of(
        {{0, 0.5f, 0}, {1, 0.5f, 0}, {1, 0.5f, 1}, {0, 0.5f, 1}}, {{0, 1, 2}, {0, 2, 3}});
    EXPECT_EQ(solid_cells(to_lattice(sheet, grid), Inside::winding).count(), 100u);
}

TEST(SolidCells, TakesWhateverComesAndTheSameOnAnyNumberOfThreads)
{
    EXPECT_EQ(solid_cells({}, Inside::winding).count(), 0u);
    EXPECT_EQ(solid_cells({}, Inside::parity).count(), 0u);
    const TriMesh soup = test_meshes::random_soup(300, 3);
    const LatticeMesh lattice = to_lattice(soup, grid_across(soup, 16));
    std::vector<Vec3i> cells;
    std::vector<std::uint64_t> inside;
    for (const unsigned threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const auto now = solid_cells(lattice, Inside::winding).sorted();
        const auto now_inside = cell_lines(lattice, Inside::winding, now).inside;
        if (cells.empty()) cells = now, inside = now_inside;
        EXPECT_EQ(now, cells);
        EXPECT_EQ(now_inside, inside);
    }
    EXPECT_THROW(solid_cells(lattice, Inside::winding, 100), geometry::TooManyCells);
}

}  // namespace
