// The pieces of a mesh, and the thickness of its walls.

#include "geometry/mesh/wall_thickness.hpp"
#include "tests/geometry/meshes.hpp"

#include <tbb/global_control.h>

namespace {

using namespace geometry;

std::vector<WallSample> walls(const TriMesh& mesh, std::size_t count, double reach)
{
    std::vector<WallSample> samples = wall_points(mesh, count);
    find_thickness(mesh, find_pieces(mesh), 1e-4, reach, samples);
    return samples;
}

TriMesh inside_out(const TriMesh& mesh)
{
    std::vector<Triangle> triangles = mesh.triangles();
    for (Triangle& t : triangles) std::swap(t[0], t[1]);
    return meshes::soup(mesh.positions, triangles);
}

TEST(WallThickness, PiecesOfAMeshHaveTheirAreaAndVolume)
{
    const TriMesh one = box({1, 2, 3}, {1, 1, 1}),
                  two = inside_out(box({0.5, 0.5, 0.5}, {2, 2, 2})), sheet = grid(2, 1, 4, 3);
    const TriMesh moved = meshes::moved(two, {4, 0, 0}), far = meshes::moved(sheet, {8, 0, 0});
    const std::array<const TriMesh*, 3> all{&one, &moved, &far};
    const Pieces pieces = find_pieces(merge(all));
    ASSERT_EQ(pieces.count(), 3u);
    const std::array<double, 3> area{22, 1.5, 2}, volume{6, -0.125, 0};
    for (std::size_t p = 0; p < 3; ++p) {
        EXPECT_NEAR(pieces.area[p], area[p], 1e-6) << p;
        EXPECT_NEAR(pieces.volume[p], volume[p], 1e-6) << p;
        EXPECT_EQ(pieces.encloses[p], p < 2 ? 1 : 0) << p;
    }
}

TEST(WallThickness, OfABoxItIsTheWayToTheOppositeFace)
{
    const TriMesh slab = box({1, 2, 0.1}, {3, 2, 1});
    for (const TriMesh& mesh : {slab, inside_out(slab)}) {
        const std::vector<WallSample> samples = walls(mesh, 2000, 1.5);
        ASSERT_EQ(samples.size(), 2000u);
        std::array<int, 3> across{};
        for (const WallSample& s : samples) {
            int axis = 0;
            EXPECT_NEAR(s.inward.cwiseAbs().maxCoeff(&axis), 1, 1e-6);
            EXPECT_LT(s.point.dot(s.inward), 0);  // towards the middle
            ++across[static_cast<std::size_t>(axis)];
            if (axis == 1) {
                EXPECT_FALSE(std::isfinite(s.thickness)) << "2 m is beyond the reach";
            } else {
                EXPECT_NEAR(s.thickness, axis == 0 ? 1 : 0.1, 1e-6);
            }
        }
        // One in each of 2,000 equal shares of the area 4.6 m^2; six groups of faces round off.
        EXPECT_NEAR(across[0], 2000 * 0.4 / 4.6, 3);
        EXPECT_NEAR(across[1], 2000 * 0.2 / 4.6, 3);
        EXPECT_NEAR(across[2], 2000 * 4.0 / 4.6, 3);
    }
}

TEST(WallThickness, AgreesWithTheChordOfABallOnAnyNumberOfThreads)
{
    // Inward from a flat face of a fine ball is along a radius within half a face's angle.
    const TriMesh ball = icosphere(1, 4);
    const std::vector<WallSample> many = walls(ball, 500, 10);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    const std::vector<WallSample> one = walls(ball, 500, 10);
    for (std::size_t i = 0; i < many.size(); ++i) {
        EXPECT_NEAR(many[i].thickness, 2, 0.01);
        EXPECT_EQ(many[i].thickness, one[i].thickness);
        EXPECT_EQ(many[i].point, one[i].point);
    }
}

// Each face twice, back to back.
TEST(WallThickness, DoubledFacesAreNoWalls)
{
    TriMesh slab = box({1, 1, 0.1}, {1, 1, 1});
    move(slab, placement({0, 0, 0}, {20, 30, 40}, {1, 1, 1}, {0, 0, 0}));  // nothing is exact
    std::vector<Triangle> triangles = slab.triangles();
    for (const Triangle& t : slab.triangles()) triangles.push_back({t[1], t[0], t[2]});
    std::size_t across = 0;
    for (const WallSample& s : walls(meshes::soup(slab.positions, triangles), 200, 0.5)) {
        if (!std::isfinite(s.thickness)) continue;
        EXPECT_NEAR(s.thickness, 0.1, 1e-6);
        ++across;
    }
    EXPECT_GT(across, 60u);
}

TEST(WallThickness, NothingIsFoundWithoutAnOppositeWall)
{
    for (const WallSample& s : walls(grid(2, 1, 4, 3), 50, 10)) {
        EXPECT_FALSE(std::isfinite(s.thickness));
    }
    EXPECT_TRUE(walls(TriMesh{}, 50, 10).empty());
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(
        walls(meshes::soup({{0, 0, 0}, {1, 0, 0}, {nan, 1, 0}}, {{0, 1, 2}, {0, 1, 7}}), 50, 10)
            .empty());
}

}  // namespace
