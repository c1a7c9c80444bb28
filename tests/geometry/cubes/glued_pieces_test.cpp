// Which separate pieces the cubes glue together.

#include "geometry/cubes/components.hpp"
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

Cubes solid_cubes_of(const TriMesh& mesh, double size, const VoxelOptions& options)
{
    return voxelize_solid(mesh, {{}, {{}}, {}}, Inside::winding, 0,
                          fit_grid(triangle_bounds(mesh), size), options);
}

GluedPieces glued(const TriMesh& mesh, double size, const VoxelOptions& options = {})
{
    return find_glued_pieces(mesh, find_pieces(mesh), solid_cubes_of(mesh, size, options),
                             options.join);
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

TEST(GluedPieces, PiecesThatAreKeptApartInOneCubeAreNotGlued)
{
    VoxelOptions apart;
    apart.pieces = NearPieces::apart;
    for (const double gap : {0.02, 0.04, 0.1, 0.15}) {
        for (const double size : {0.19, 0.2, 0.2317}) {
            const TriMesh mesh = together({block(0), block(1 + gap)});
            ASSERT_EQ(glued(mesh, size).count, 2u) << gap << " " << size;
            const bool one =
                find_components(solid_cubes_of(mesh, size, apart), Connectivity::corner).count() ==
                1;
            EXPECT_EQ(glued(mesh, size, apart).count, one ? 2u : 0u) << gap << " " << size;
            EXPECT_FALSE(one && gap >= 0.5 * size) << gap << " " << size;
        }
    }
    // Those that a stated gap joins are joined on purpose.
    VoxelOptions joined = apart;
    joined.join = 0.12;
    EXPECT_EQ(glued(together({block(0), block(1.1)}), 0.2, joined).count, 0u);
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

// A ball in the middle of a block: their surfaces are farther apart than a cube, or than points of
// them.
TEST(GluedPieces, APieceDeepWithinAnotherIsOneBodyWithIt)
{
    const TriMesh inner = meshes::moved(icosphere(0.1, 2), {0.5, 0, 0});
    const TriMesh outer = meshes::moved(box({1, 1, 1}, {1, 1, 1}), {0.5, 0, 0});
    for (const double size : {0.2, 0.3, 0.35}) {
        EXPECT_EQ(glued(together({outer, inner}), size).count, 0u) << size;
        EXPECT_EQ(glued(together({inner, outer}), size).count, 0u) << size;
    }
}

// Points of the two lie on either side of where they cross.
TEST(GluedPieces, ARodThatEndsWithinABlockIsOneBodyWithIt)
{
    for (int step = 0; step < 20; ++step) {
        const double in = 0.1 + 0.013 * step;
        const TriMesh rod =
            meshes::moved(box({2, 0.01, 0.01}, {1, 1, 1}), {1 + 1 - in, 0.137, 0.071});
        const TriMesh block = meshes::moved(box({1, 1, 1}, {1, 1, 1}), {0.5, 0, 0});
        EXPECT_EQ(glued(together({block, rod}), 0.2).count, 0u) << in;
        EXPECT_EQ(glued(together({rod, block}), 0.2).count, 0u) << in;
    }
}

// Blocks in a row, of a few large triangles each: the least gap is that of the pair.
TEST(GluedPieces, OfManyPiecesTheNearestTwoAreFound)
{
    for (std::size_t nearest = 0; nearest < 9; ++nearest) {
        std::vector<TriMesh> all;
        double x = 0, least = 0;
        for (std::size_t i = 0; i < 10; ++i) {
            all.push_back(block(x));
            const double gap = i == nearest ? 0.021 : 0.03 + 0.007 * static_cast<double>(i);
            if (i == nearest) least = gap;
            x += 1 + gap;
        }
        const GluedPieces found = glued(together(all), 0.25);
        EXPECT_EQ(found.count, 10u);
        EXPECT_EQ(found.pair[0], nearest);
        EXPECT_EQ(found.pair[1], nearest + 1);
        EXPECT_NEAR(found.gap, least, 1e-5);
    }
}

TEST(GluedPieces, AreFoundAmongMoreThanAThousand)
{
    // In a grid of 10 x 10 x 11, far from each other but for the last.
    std::vector<TriMesh> all;
    for (int i = 0; i < 1100; ++i) {
        const Vec3 at = Vec3i(i % 10, i / 10 % 10, i / 100).cast<double>();
        all.push_back(meshes::moved(box({1, 1, 1}, {1, 1, 1}), 3 * at));
    }
    all.push_back(meshes::moved(box({1, 1, 1}, {1, 1, 1}), {28.15, 27, 30}));
    const GluedPieces found = glued(together(all), 0.2);
    EXPECT_EQ(found.count, 2u);
    EXPECT_EQ(found.pair, (std::array<std::uint32_t, 2>{1099, 1100}));
    EXPECT_NEAR(found.gap, 0.15, 1e-5);
    EXPECT_FALSE(found.at_least);
}

// 299 pairs in a row, of which 256 are looked at.
TEST(GluedPieces, OfVeryManyTheCountIsTheLeast)
{
    std::vector<TriMesh> all;
    for (int i = 0; i < 300; ++i) {
        all.push_back(meshes::moved(box({0.2, 0.2, 0.2}, {1, 1, 1}), {0.3 * i, 0, 0}));
    }
    const GluedPieces found = glued(together(all), 0.2);
    EXPECT_TRUE(found.at_least);
    EXPECT_GE(found.count, 256u);
    EXPECT_LT(found.count, 300u);
}

// However it lies in the grid.
TEST(GluedPieces, TheGapOfATurnedBlockIsThatOfItsLowestCorner)
{
    const TriMesh plain = box({1, 0.4, 0.3}, {1, 1, 1});
    for (int turn = 0; turn < 12; ++turn) {
        TriMesh turned = plain;
        const Eigen::Matrix3f r =
            Eigen::AngleAxisf(0.25f * static_cast<float>(turn) + 0.1f,
                              Eigen::Vector3f(1, 0.3f * static_cast<float>(turn), 2).normalized())
                .toRotationMatrix();
        float lowest = 0;
        for (Vec3f& p : turned.positions) {
            p = r * p;
            lowest = std::min(lowest, p.y());
        }
        // A corner stands this far above the plain block's upper face.
        for (Vec3f& p : turned.positions) p.y() += 0.2f + 0.05f - lowest;
        const GluedPieces found = glued(together({plain, turned}), 0.3);
        EXPECT_EQ(found.count, 2u) << turn;
        EXPECT_NEAR(found.gap, 0.05, 1e-5) << turn;
    }
}

TEST(GluedPieces, OnePieceIsNeverGlued)
{
    EXPECT_EQ(glued(torus(1, 0.05, 40, 16), 0.2).count, 0u);
}

}  // namespace
