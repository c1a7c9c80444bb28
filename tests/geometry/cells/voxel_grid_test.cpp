#include "geometry/cells/voxel_grid.hpp"

#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::Box;
using geometry::fit_grid;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using geometry::Vec3i;

TEST(VoxelGrid, AModelOfWholeCubesGetsNoCubeMore)
{
    // 0.1 and 0.3 are no binary fractions, and the mesh holds them in single precision.
    const TriMesh box = test_meshes::box({-0.3, 0, 0.1}, {0.7, 0.1, 0.4});
    const auto grid = fit_grid(triangle_bounds(box), 0.1);
    EXPECT_EQ(grid.cells, Vec3i(10, 1, 3));
    for (const Vec3f& p : box.positions) {
        const Vec3 q = grid.lattice(p);
        EXPECT_TRUE((q.array() >= 0).all());
        EXPECT_TRUE((q.array() < grid.cells.cast<double>().array()).all());
        const Vec3i cell = geometry::cell_of(q);
        for (int k = 0; k < 3; ++k) EXPECT_TRUE(cell[k] == 0 || cell[k] == grid.cells[k] - 1);
    }
}

TEST(VoxelGrid, SharesWhatIsLeftOverBetweenBothSides)
{
    const auto grid = fit_grid({{0, 0, 0}, {1, 2, 0}}, 0.8);
    EXPECT_EQ(grid.cells, Vec3i(2, 3, 1));
    EXPECT_NEAR((grid.origin - Vec3(-0.3, -0.2, -0.4)).norm(), 0, 1e-15);
}

TEST(VoxelGrid, SaysWhatIsWrong)
{
    EXPECT_THROW(fit_grid(Box{}, 1), std::invalid_argument);
    EXPECT_THROW(fit_grid({{0, 0, 0}, {1, 1, 1}}, 0), std::invalid_argument);
    EXPECT_THROW(fit_grid({{0, 0, 0}, {1, 1, 1}}, std::nan("")), std::invalid_argument);
    EXPECT_THROW(geometry::size_for({{1, 1, 1}, {1, 1, 1}}, 10), std::invalid_argument);
    try {
        fit_grid({{0, 0, 0}, {2e6, 1, 1}}, 1);
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("at least 1.93 m"), std::string::npos) << e.what();
    }
}

TEST(VoxelGrid, LeavesOutTrianglesThatAreNotThere)
{
    const float inf = std::numeric_limits<float>::infinity();
    const TriMesh mesh = test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, inf, 0}},
                                              {{0, 1, 3}, {0, 1, 2}, {0, 1, 7}});
    const auto lattice = to_lattice(mesh, {});
    EXPECT_EQ(lattice.triangles.size(), 1u);
    EXPECT_EQ(lattice.source_of(0), 1u);
    EXPECT_NEAR(triangle_bounds(mesh).diagonal(), std::sqrt(2.0), 1e-15);
    TriMesh far = mesh;
    far.positions[2].y() = 1e9f;
    EXPECT_THROW(to_lattice(far, {}), std::invalid_argument);
    EXPECT_EQ(fit_grid(triangle_bounds(far), 1e5).cells, Vec3i(1, 10000, 1));
}

}  // namespace
