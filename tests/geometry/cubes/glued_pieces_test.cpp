// Which separate pieces the cubes glue together.

#include "geometry/cubes/glued_pieces.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "tests/geometry/meshes.hpp"

#include <cmath>

namespace {

using namespace geometry;

TriMesh together(const std::vector<TriMesh>& all)
{
    std::vector<const TriMesh*> pointers;
    for (const TriMesh& mesh : all) pointers.push_back(&mesh);
    return merge(pointers);
}

GluedPieces glued(const TriMesh& mesh, double size)
{
    const Cubes cubes = voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0,
                                       fit_grid(triangle_bounds(mesh), size), {});
    return find_glued_pieces(mesh, find_pieces(mesh), cubes);
}

TriMesh block(double x)
{
    return meshes::moved(box({1, 1, 1}, {1, 1, 1}), {x, 0, 0});
}

TEST(GluedPieces, PiecesNearerThanACubeAreGluedAndFartherOnesAreNot)
{
    for (const double gap : {0.03, 0.07, 0.15}) {
        const TriMesh mesh = together({block(0), block(1 + gap), block(5)});
        const GluedPieces found = glued(mesh, 0.2);
        EXPECT_EQ(found.count, 2u);
        EXPECT_EQ(found.pair, (std::array<std::uint32_t, 2>{0, 1}));
        EXPECT_NEAR(found.gap, gap, 1e-6);
        EXPECT_GT(found.size, gap / 2.5);
        EXPECT_LT(found.size, gap / 2);
        // With the size that is suggested they are apart, in other components too.
        EXPECT_EQ(glued(mesh, found.size).count, 0u) << gap;
    }
    EXPECT_EQ(glued(together({block(0), block(1.45)}), 0.2).count, 0u);
}

TEST(GluedPieces, PiecesThatTouchOrOverlapAreOneBody)
{
    EXPECT_EQ(glued(together({block(0), block(1)}), 0.2).count, 0u) << "face to face";
    EXPECT_EQ(glued(together({block(0), block(0.9)}), 0.2).count, 0u) << "overlapping";
    EXPECT_EQ(glued(together({block(0), block(0.9), block(1.95)}), 0.2).count, 2u);
    const TriMesh beam = meshes::moved(box({3, 0.5, 0.5}, {1, 1, 1}), {0.5, 0, 0});
    EXPECT_EQ(glued(together({block(0), block(1.1), beam}), 0.2).count, 0u) << "joined by a third";
}

TEST(GluedPieces, TheGapIsThatOfTheNearestPoints)
{
    // Two balls of radius 1: the points are a third of a cube apart, which leaves about
    // 2 (0.2 / 3)^2 / 2 of the gap.
    const TriMesh ball = icosphere(1, 4);
    const GluedPieces found = glued(together({ball, meshes::moved(ball, {2.1, 0, 0})}), 0.2);
    EXPECT_EQ(found.count, 2u);
    EXPECT_NEAR(found.gap, 0.1, 0.01);
}

TEST(GluedPieces, OnePieceIsNeverGlued)
{
    EXPECT_EQ(glued(torus(1, 0.05, 40, 16), 0.2).count, 0u);
}

}  // namespace
