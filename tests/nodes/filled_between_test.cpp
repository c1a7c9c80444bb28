// What Voxelize says of leaves that it fills the crown of a tree with.

#include "nodes/filled_between.hpp"

#include "geometry/base/random.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/test_meshes.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3f;

// Squares of 0.12 m in a ball of 1 m, that look outwards as leaves do.
TriMesh crown(std::uint32_t count)
{
    const geometry::Random random(3);
    std::vector<Vec3f> positions;
    std::vector<geometry::Triangle> triangles;
    for (std::uint32_t i = 0; triangles.size() < 2 * count; ++i) {
        const auto unit = [&](std::uint32_t k) {
            return static_cast<float>(2 * random.unit(3 * i + k) - 1);
        };
        const Vec3f at(unit(0), unit(1), unit(2));
        if (at.norm() > 1 || at.norm() < 0.7f) continue;
        const Vec3f u = 0.06f * at.unitOrthogonal(), v = at.normalized().cross(u);
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const Vec3f& side : {Vec3f(-u - v), Vec3f(u - v), Vec3f(u + v), Vec3f(v - u)}) {
            positions.push_back(at + side);
        }
        triangles.push_back({first, first + 1, first + 2});
        triangles.push_back({first, first + 2, first + 3});
    }
    return test_meshes::mesh_of(positions, triangles);
}

// The faces of a box, each with vertices of its own and smaller by a share.
TriMesh tiles(double gap)
{
    const TriMesh box = geometry::box({1, 1, 1}, {4, 4, 4});
    std::vector<Vec3f> positions;
    std::vector<geometry::Triangle> triangles;
    for (const auto& [a, b, c] : box.triangles()) {
        const Vec3f middle = (box.positions[a] + box.positions[b] + box.positions[c]) / 3;
        const auto first = static_cast<std::uint32_t>(positions.size());
        for (const auto v : {a, b, c}) {
            positions.push_back(middle + static_cast<float>(1 - gap) * (box.positions[v] - middle));
        }
        triangles.push_back({first, first + 1, first + 2});
    }
    return test_meshes::mesh_of(positions, triangles);
}

std::string warnings_of(const TriMesh& mesh, const std::string& pieces, const std::string& method)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("method").is = method;
    node.param("size").is = 0.2;
    node.param("pieces").is = pieces;
    node.run();
    std::string all;
    for (const auto& text : node.warnings) all += text + "\n";
    return all;
}

TEST(FilledBetween, LeavesThatFillTheirCrownAreTold)
{
    const TriMesh leaves = crown(400);
    const std::string text = warnings_of(leaves, "merge", "solid");
    EXPECT_NE(text.find("400 open pieces of the mesh hold nothing by themselves"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("set pieces = each"), std::string::npos) << text;
    EXPECT_EQ(warnings_of(leaves, "each", "solid").find("by themselves"), std::string::npos);
    EXPECT_EQ(warnings_of(leaves, "merge", "surface").find("by themselves"), std::string::npos);
    // Also where they are so dense that each nearly touches another.
    const auto dense = nodes::find_filled_between(crown(10000), geometry::Inside::winding);
    EXPECT_EQ(dense.pieces, 10000u);
    EXPECT_TRUE(dense.filled());
    // Most of the inside is that of a block.
    TriMesh block = geometry::box({6, 6, 6}, {1, 1, 1});
    for (Vec3f& p : block.positions) p.x() += 5;
    EXPECT_FALSE(
        nodes::find_filled_between(test_meshes::both(leaves, block), geometry::Inside::winding)
            .filled());
}

TEST(FilledBetween, LoosePolygonsOfASolidAreNot)
{
    const geometry::Inside winding = geometry::Inside::winding;
    EXPECT_NEAR(geometry::volume_inside(tiles(0.01), winding), 1, 0.05);
    EXPECT_FALSE(nodes::find_filled_between(tiles(0.01), winding).filled());
    EXPECT_FALSE(nodes::find_filled_between(tiles(0), winding).filled());
    // Two sheets far from each other hold nothing between them.
    TriMesh above = geometry::grid(1, 1, 1, 1);
    for (Vec3f& p : above.positions) p.y() += 5;
    const TriMesh sheets = test_meshes::both(geometry::grid(1, 1, 1, 1), above);
    EXPECT_FALSE(nodes::find_filled_between(sheets, winding).filled());
}

}  // namespace
