#include "geometry/embed/t_junctions.hpp"

#include "geometry/mesh/mesh_edges.hpp"
#include "tests/geometry/embed/torn_blocks.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

using namespace geometry;
using namespace torn_blocks;

namespace {

// A square of two faces, and one farther off, in cubes of 1 m. The first face is cut at two points
// of the edge that it shares with the second.
struct CutSquare {
    Cubes cubes = block({2, 2, 1}, 1, Vec3::Zero());
    TriMesh rest = meshes::soup({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 2, 0}, {2, 1, 0}},
                                {{0, 1, 2}, {0, 2, 3}, {2, 5, 4}});
    CutFaces cut;

    CutSquare()
    {
        cut.cut = {1, 0, 0};
        const auto add = [&](double a, double b, double c) {
            cut.corners.push_back({0, no_index, Vec3(b + c, c, 0), {a, b, c}});
        };
        add(1, 0, 0);
        add(0, 1, 0);
        add(0, 0, 1);
        add(0.75, 0, 0.25);
        add(0.5, 0, 0.5);
        cut.faces = {{0, 1, 3}, {3, 1, 4}, {4, 1, 2}};
    }
};

TEST(TJunctions, AreSplitInTheFaceBeside)
{
    CutSquare square;
    split_at_t_junctions(square.rest, square.cubes, square.cut);
    const CutFaces& cut = square.cut;
    EXPECT_EQ(cut.cut, (std::vector<std::uint8_t>{1, 1, 0}));
    ASSERT_EQ(cut.faces.size(), 6u);
    double area = 0;
    std::vector<Triangle> faces;
    for (const auto& [a, b, c] : cut.faces) {
        const auto& corners = cut.corners;
        const Vec3 normal = (corners[b].at - corners[a].at).cross(corners[c].at - corners[a].at);
        EXPECT_GT(normal.z(), 0);
        area += normal.norm() / 2;
        EXPECT_EQ(corners[a].face, corners[b].face);
        EXPECT_EQ(corners[a].face, corners[c].face);
        faces.push_back({corners[a].place, corners[b].place, corners[c].place});
    }
    EXPECT_NEAR(area, 1, 1e-12);
    const auto borders = border_loops(faces, cut.corners.size());
    ASSERT_EQ(borders.size(), 1u);
    EXPECT_EQ(borders[0].size(), 4u);
    // Corners are where their shares of their face say.
    for (const CutFaces::Corner& c : cut.corners) {
        Vec3 at = Vec3::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            at += c.share[k] *
                  square.rest.positions[square.rest.triangles()[c.face][k]].cast<double>();
        }
        EXPECT_NEAR((at - c.at).norm(), 0, 1e-12);
    }
}

}  // namespace
