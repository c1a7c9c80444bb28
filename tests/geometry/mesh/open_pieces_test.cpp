#include "geometry/mesh/open_pieces.hpp"

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/cut_meshes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace {

using geometry::OpenPiece;
using geometry::TriMesh;
using geometry::Vec3;
using test_meshes::cut_above;

std::vector<OpenPiece> found_in(const TriMesh& mesh)
{
    return geometry::open_pieces(mesh, geometry::find_pieces(mesh));
}

TEST(OpenPieces, ABowlHoldsHalfOfItsBall)
{
    const TriMesh ball = geometry::uv_sphere(0.5, 48, 24);
    const auto open = found_in(cut_above(ball, 0));
    ASSERT_EQ(open.size(), 1u);
    EXPECT_NEAR(open[0].volume, geometry::enclosed_volume(ball) / 2, 1e-6);
    // A regular polygon of 48 corners.
    const double lid = 48 * 0.25 * std::sin(2 * std::numbers::pi / 48) / 2;
    EXPECT_NEAR(open[0].lids, lid, 1e-6);
    EXPECT_NEAR(open[0].across, 2 * std::sqrt(lid / std::numbers::pi), 1e-6);
    EXPECT_LT(open[0].centre.norm(), 1e-6);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : open[0].half_way) {
        EXPECT_NEAR(p.norm(), 0.25, 1e-6);
        sum += p;
    }
    EXPECT_LT(sum.norm(), 1e-6) << "all around";
}

TEST(OpenPieces, ATubeHasTwoHolesAndWhatIsClosedHasNone)
{
    const TriMesh box = geometry::box({1, 2, 3}, {1, 1, 1});
    EXPECT_TRUE(found_in(box).empty());
    TriMesh tube = cut_above(box, 0.99f);
    for (auto& p : tube.positions) p.y() *= -1;  // turns it inside out: so is the result's sign
    tube = cut_above(tube, 0.99f);
    const auto open = found_in(tube);
    ASSERT_EQ(open.size(), 1u);
    EXPECT_NEAR(open[0].volume, 6, 1e-9);
    EXPECT_NEAR(open[0].lids, 2 * 3, 1e-9);
}

TEST(OpenPieces, ASheetHoldsNothingAndAFaceTurnedRoundIsNoHole)
{
    const auto sheet = found_in(geometry::grid(2, 1, 4, 4));
    ASSERT_EQ(sheet.size(), 1u);
    EXPECT_NEAR(sheet[0].volume, 0, 1e-9);
    EXPECT_NEAR(sheet[0].lids, 2, 1e-9);
    const TriMesh box = geometry::box({1, 1, 1}, {3, 3, 3});
    auto faces = box.triangles();
    std::swap(faces[0][0], faces[0][1]);
    EXPECT_TRUE(found_in(test_meshes::mesh_of(box.positions, faces)).empty());
}

}  // namespace
