#include "geometry/solid_cells.hpp"

#include "geometry/surface_cells.hpp"
#include "geometry/triangle_bvh.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace {

using geometry::CellSet;
using geometry::Inside;
using geometry::LatticeMesh;
using geometry::Touch;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3i;
using geometry::VoxelGrid;

VoxelGrid grid_of(const TriMesh& mesh, int resolution)
{
    const auto box = triangle_bounds(mesh);
    return fit_grid(box, size_for(box, resolution));
}

TriMesh turned(const TriMesh& mesh)
{
    auto triangles = mesh.triangles();
    for (auto& t : triangles) std::swap(t[1], t[2]);
    return test_meshes::mesh_of(mesh.positions, triangles);
}

TEST(SolidCells, AreTheSurfaceAndEveryCentreWithAWindingNumber)
{
    using test_meshes::both;
    const TriMesh ball = test_meshes::bumpy_sphere(3);
    TriMesh moved = test_meshes::icosphere(2);
    for (auto& p : moved.positions) p = 0.8f * p + geometry::Vec3f(0.7f, 0.3f, -0.2f);
    TriMesh hole = turned(test_meshes::icosphere(2));
    for (auto& p : hole.positions) p *= 0.4f;
    for (const TriMesh& mesh :
         {ball, turned(ball), both(ball, ball), both(ball, moved), both(ball, hole)}) {
        const VoxelGrid grid = grid_of(mesh, 16);
        const LatticeMesh lattice = to_lattice(mesh, grid);
        const CellSet cells = solid_cells(lattice, Inside::winding);
        const CellSet surface = surface_cells(lattice, Touch::interior);
        const geometry::TriangleBvh bvh(mesh);
        for (int i = 0; i < grid.cells.prod(); ++i) {
            const Vec3i c(i % grid.cells.x(), i / grid.cells.x() % grid.cells.y(),
                          i / grid.cells.x() / grid.cells.y());
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
    const VoxelGrid grid = grid_of(ball, 30);
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
    VoxelGrid grid = grid_of(ball, 40);
    for (const Inside rule : {Inside::winding, Inside::parity}) {
        const CellSet cells = solid_cells(to_lattice(open, grid), rule);
        for (int i = 0; i < grid.cells.prod(); ++i) {
            const Vec3i c(i % grid.cells.x(), i / grid.cells.x() % grid.cells.y(),
                          i / grid.cells.x() / grid.cells.y());
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

TEST(SolidCells, AnAlignedBoxIsExactlyItsCubes)
{
    // Between other cubes, so that no face is at the grid's end.
    const TriMesh mesh = test_meshes::box({0.2, 0.3, 0.1}, {0.7, 0.5, 0.4});
    VoxelGrid grid;
    grid.size = 0.1;
    const LatticeMesh lattice = to_lattice(mesh, grid);
    const auto cells = solid_cells(lattice, Inside::winding).sorted();
    EXPECT_EQ(cells.size(), 5u * 2 * 3);
    for (const float share : inside_shares(lattice, Inside::winding, cells)) EXPECT_EQ(share, 1);
    // A sheet on a face between cells has no inside but is not lost.
    const TriMesh sheet = test_meshes::mesh_of(
        {{0, 0.5f, 0}, {1, 0.5f, 0}, {1, 0.5f, 1}, {0, 0.5f, 1}}, {{0, 1, 2}, {0, 2, 3}});
    EXPECT_EQ(solid_cells(to_lattice(sheet, grid), Inside::winding).count(), 100u);
}

TEST(SolidCells, SharesAddUpToTheVolume)
{
    const TriMesh mesh = test_meshes::icosphere(4);
    double volume = 0;  // the divergence theorem over the polyhedron
    for (const auto& [a, b, c] : mesh.triangles()) {
        volume += mesh.positions[a].cast<double>().dot(
                      mesh.positions[b].cast<double>().cross(mesh.positions[c].cast<double>())) /
                  6;
    }
    const VoxelGrid grid = grid_of(mesh, 20);
    const LatticeMesh lattice = to_lattice(mesh, grid);
    const auto cells = solid_cells(lattice, Inside::winding).sorted();
    double sum = 0;
    for (const float share : inside_shares(lattice, Inside::winding, cells)) sum += double(share);
    // About 1,900 border cells, each off by at most some 0.05 at random: 5 sigma of their sum.
    EXPECT_NEAR(sum * std::pow(grid.size, 3), volume, 5 * 0.05 * std::sqrt(1900) * 1e-3);
}

TEST(SolidCells, TakesWhateverComesAndTheSameOnAnyNumberOfThreads)
{
    EXPECT_EQ(solid_cells({}, Inside::winding).count(), 0u);
    EXPECT_EQ(solid_cells({}, Inside::parity).count(), 0u);
    const TriMesh soup = test_meshes::random_soup(300, 3);
    const LatticeMesh lattice = to_lattice(soup, grid_of(soup, 16));
    std::vector<Vec3i> cells;
    std::vector<float> shares;
    for (const std::size_t threads : {1, 2, 8}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const auto now = solid_cells(lattice, Inside::winding).sorted();
        const auto now_shares = inside_shares(lattice, Inside::winding, now);
        if (cells.empty()) cells = now, shares = now_shares;
        EXPECT_EQ(now, cells);
        EXPECT_EQ(now_shares, shares);
    }
    EXPECT_THROW(solid_cells(lattice, Inside::winding, 100), geometry::TooManyCells);
}

}  // namespace
