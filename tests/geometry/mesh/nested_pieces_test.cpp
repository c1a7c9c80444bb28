#include "geometry/mesh/nested_pieces.hpp"

#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::NestedPiece;
using geometry::TriMesh;

TriMesh nested_in_one(const std::vector<TriMesh>& all)
{
    std::vector<const TriMesh*> each;
    for (const TriMesh& mesh : all) each.push_back(&mesh);
    return geometry::merge(each);
}

TriMesh centred_ball(double radius, float x = 0)
{
    TriMesh mesh = geometry::icosphere(radius, 2);
    for (auto& p : mesh.positions) p.x() += x;
    return mesh;
}

TriMesh looking_in(TriMesh mesh)
{
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    for (auto& t : topology->triangles) std::swap(t[1], t[2]);
    mesh.topology = std::move(topology);
    return mesh;
}

std::vector<NestedPiece> nested_in(const TriMesh& mesh)
{
    return geometry::nested_pieces(mesh, geometry::find_pieces(mesh));
}

TEST(NestedPieces, AreThoseThatLieWhollyInOthers)
{
    EXPECT_TRUE(nested_in({}).empty());
    EXPECT_TRUE(nested_in(centred_ball(1)).empty());
    // Apart; across the border of another; in the corner of another's box.
    EXPECT_TRUE(nested_in(nested_in_one({centred_ball(1), centred_ball(0.5, 2)})).empty());
    EXPECT_TRUE(nested_in(nested_in_one({centred_ball(1), centred_ball(0.5, 0.9f)})).empty());
    TriMesh corner = centred_ball(0.1);
    for (auto& p : corner.positions) p += geometry::Vec3f::Constant(0.8f);
    EXPECT_TRUE(nested_in(nested_in_one({centred_ball(1), corner})).empty());
    const auto found = nested_in(nested_in_one(
        {centred_ball(0.2, 0.1f), centred_ball(0.5), centred_ball(1), centred_ball(0.2, 0.7f)}));
    ASSERT_EQ(found.size(), 3u);
    const auto expect = [&](std::size_t i, std::uint32_t piece, std::uint32_t around, int depth) {
        EXPECT_EQ(found[i].piece, piece);
        EXPECT_EQ(found[i].around, around);
        EXPECT_EQ(found[i].depth, depth);
        EXPECT_EQ(found[i].winding, depth);
    };
    expect(0, 0, 1, 2), expect(1, 1, 2, 1), expect(2, 3, 2, 1);
}

// A hollow that looks in is one, and a ball that lies in it is no second filling.
TEST(NestedPieces, AHollowAndWhatLiesInItAreNotWoundAsAround)
{
    const TriMesh mesh =
        nested_in_one({centred_ball(1), looking_in(centred_ball(0.8)), centred_ball(0.5)});
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    const auto nested = geometry::nested_pieces(mesh, pieces);
    ASSERT_EQ(nested.size(), 2u);
    for (const NestedPiece& n : nested) EXPECT_FALSE(geometry::is_wound_as_around(pieces, n));
    EXPECT_EQ(nested[1].winding, 0);
    const TriMesh filled = nested_in_one({centred_ball(1), centred_ball(0.8)});
    EXPECT_TRUE(geometry::is_wound_as_around(geometry::find_pieces(filled), nested_in(filled)[0]));
}

TEST(NestedPieces, LookInAndOutByTurnsByParity)
{
    const double one = geometry::enclosed_volume(centred_ball(1));
    for (const bool both : {false, true}) {
        TriMesh mesh = both ? nested_in_one({centred_ball(1), centred_ball(0.8), centred_ball(0.5)})
                            : nested_in_one({centred_ball(1), looking_in(centred_ball(0.8)),
                                             looking_in(centred_ball(0.5))});
        geometry::wind_by_parity(mesh);
        EXPECT_NEAR(geometry::enclosed_volume(mesh), (1 - 0.512 + 0.125) * one, 1e-5);
    }
}

}  // namespace
