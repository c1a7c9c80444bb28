#include "geometry/mesh/mesh_edges.hpp"

#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using geometry::edge_uses;
using geometry::is_closed;
using geometry::TriMesh;

bool closed(const TriMesh& mesh)
{
    return is_closed(mesh.triangles(), mesh.positions.size());
}

TEST(MeshEdges, EveryEdgeOfAClosedManifoldIsUsedOnceEachWay)
{
    const TriMesh mesh = test_meshes::icosphere(2);
    const auto uses = edge_uses(mesh.triangles(), mesh.positions.size());
    ASSERT_EQ(uses.size(), 3 * mesh.triangles().size());
    for (std::size_t i = 0; i < uses.size(); i += 2) {
        EXPECT_EQ(uses[i].a, uses[i + 1].a);
        EXPECT_EQ(uses[i].b, uses[i + 1].b);
        EXPECT_NE(uses[i].forward, uses[i + 1].forward);
        const auto& t = mesh.triangles()[uses[i].triangle];
        EXPECT_EQ(t[uses[i].side], uses[i].forward ? uses[i].a : uses[i].b);
    }
}

TEST(MeshEdges, AMeshIsClosedWhenNoBorderIsLeft)
{
    const TriMesh ball = test_meshes::icosphere(1);
    EXPECT_TRUE(closed(ball));
    EXPECT_TRUE(closed(test_meshes::both(ball, ball)));
    EXPECT_TRUE(closed(TriMesh{}));
    auto triangles = ball.triangles();
    triangles.pop_back();
    EXPECT_FALSE(closed(test_meshes::mesh_of(ball.positions, triangles)));
    triangles = ball.triangles();
    std::swap(triangles[3][0], triangles[3][1]);  // one face turned over
    EXPECT_FALSE(closed(test_meshes::mesh_of(ball.positions, triangles)));
    triangles = ball.triangles();
    triangles.push_back({4, 4, 7});  // names a vertex twice: no area, no border
    triangles.push_back({0, 1, 99999});
    EXPECT_TRUE(closed(test_meshes::mesh_of(ball.positions, triangles)));
}

TEST(MeshEdges, FacesDisagreeAtTheEdgesBetweenTheTurnedAndTheOthers)
{
    const auto count = [](const TriMesh& mesh) {
        return geometry::disagreeing_edges(mesh.triangles(), mesh.positions.size());
    };
    const TriMesh ball = test_meshes::icosphere(1);
    EXPECT_EQ(count(ball), 0u);
    auto triangles = ball.triangles();
    for (auto& t : triangles) std::swap(t[0], t[1]);
    EXPECT_EQ(count(test_meshes::mesh_of(ball.positions, triangles)), 0u);
    triangles = ball.triangles();
    std::swap(triangles[3][0], triangles[3][1]);
    EXPECT_EQ(count(test_meshes::mesh_of(ball.positions, triangles)), 3u);
    EXPECT_EQ(count(test_meshes::both(ball, ball)), 0u);
    triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};  // three at an edge: nobody knows
    EXPECT_EQ(count(test_meshes::mesh_of(ball.positions, triangles)), 0u);
}

std::vector<std::size_t> rims(const TriMesh& mesh, std::vector<std::size_t> without)
{
    std::vector<geometry::Triangle> triangles;
    for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
        if (std::find(without.begin(), without.end(), t) == without.end()) {
            triangles.push_back(mesh.triangles()[t]);
        }
    }
    std::vector<std::size_t> lengths;
    for (const auto& rim : geometry::border_loops(triangles, mesh.positions.size())) {
        lengths.push_back(rim.size());
    }
    std::sort(lengths.begin(), lengths.end());
    return lengths;
}

// Of an icosahedron, triangles 0 and 1 share an edge, 0 and 2 a vertex, 0 and 14 nothing.
TEST(MeshEdges, EachHoleHasARimOfItsOwn)
{
    using Lengths = std::vector<std::size_t>;
    const TriMesh ball = test_meshes::icosphere(0);
    EXPECT_EQ(rims(ball, {}), Lengths{});
    EXPECT_EQ(rims(ball, {0}), Lengths{3});
    EXPECT_EQ(rims(ball, {0, 1}), Lengths{4});
    EXPECT_EQ(rims(ball, {0, 14}), (Lengths{3, 3}));
    EXPECT_EQ(rims(ball, {0, 2}), Lengths{6});  // past their common vertex twice
    const TriMesh bow = test_meshes::mesh_of(
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
    EXPECT_EQ(rims(bow, {}), (Lengths{3, 3}));
    const TriMesh pair = test_meshes::both(ball, ball);
    EXPECT_EQ(rims(pair, {0, 20}), (Lengths{3, 3}));
}

TEST(MeshEdges, ARimRunsAsTheTrianglesBesideItDo)
{
    const TriMesh sheet = test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                               {{0, 1, 2}, {0, 2, 3}, {5, 0, 1}, {1, 1, 2}});
    const auto loops = geometry::border_loops(sheet.triangles(), sheet.positions.size());
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_EQ(loops[0], (std::vector<std::uint32_t>{0, 1, 2, 3}));
}

}  // namespace
