#include "geometry/mesh/clip.hpp"

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <gtest/gtest.h>

#include <map>

namespace geometry {

// A box of 1 x 2 x 3 m about the origin, cut at y = 0.25: the side faces lose 0.75 of their height,
// the top goes.
TEST(Clip, LeavesTheAreaBeforeThePlane)
{
    const TriMesh box = geometry::box({1, 2, 3}, {3, 4, 5});
    const TriMesh cut = clipped(box, 1, 0.25f);
    EXPECT_NEAR(surface_area(cut), 1 * 3 + 1.25 * (2 * 1 + 2 * 3), 1e-5);
    for (const Vec3f& p : cut.positions) EXPECT_LE(p.y(), 0.25f);
}

// Neighbours share the corners that a cut makes of their side: only sides in the plane are open.
TEST(Clip, IsOpenInThePlaneOnly)
{
    const TriMesh cut = clipped(icosphere(1, 2), 0, 0.3f);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const Triangle& t : cut.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) ++sides[std::minmax(t[k], t[(k + 1) % 3])];
    }
    int open = 0;
    for (const auto& [side, faces] : sides) {
        ASSERT_LE(faces, 2);
        if (faces == 2) continue;
        ++open;
        EXPECT_EQ(cut.positions[side.first].x(), 0.3f);
        EXPECT_EQ(cut.positions[side.second].x(), 0.3f);
    }
    EXPECT_GT(open, 10);
    EXPECT_EQ(cut.normals.size(), cut.positions.size());
}

// Lines of the mesh in the plane make no slivers.
TEST(Clip, KeepsFacesWhoseCornersLieInThePlane)
{
    const TriMesh box = geometry::box({1, 1, 1}, {2, 2, 2});
    const TriMesh cut = clipped(box, 2, 0.f);
    EXPECT_EQ(cut.triangles().size(), 8u + 4 * 4);
    EXPECT_NEAR(surface_area(cut), 1 + 4 * 0.5, 1e-6);
    EXPECT_TRUE(clipped(box, 2, -1.f).positions.empty());
    EXPECT_EQ(clipped(box, 2, 1.f).triangles().size(), box.triangles().size());
}

}  // namespace geometry
