// What Voxelize says of bodies that weigh what min_fill gives them.

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;

// In cubes of 0.1 m.
NodeRun cubes_node(const TriMesh& mesh, const std::string& pieces)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("method").is = std::string("solid");
    node.param("pieces").is = pieces;
    node.param("size").is = 0.1;
    return node;
}

std::string told(NodeRun& node)
{
    node.run();
    for (const auto& text : node.warnings) {
        if (text.find("no volume") != std::string::npos) return text;
    }
    return {};
}

TEST(NoVolume, AFlatFaceWithoutThicknessIsTold)
{
    const TriMesh flat = geometry::grid(1, 1, 1, 1);
    for (const std::string pieces : {"merge", "apart", "each"}) {
        NodeRun node = cubes_node(flat, pieces);
        // 100 cubes of 1 kg.
        EXPECT_NE(told(node).find("the mesh encloses no volume: it weighs 2 kg, which is what "
                                  "min_fill = 0.02 gives"),
                  std::string::npos)
            << pieces << ": " << told(node);
    }
    NodeRun thick = cubes_node(flat, "merge");
    thick.param("thickness").is = 0.003;
    EXPECT_EQ(told(thick), "");
    NodeRun stated = cubes_node(flat, "merge");
    stated.param("total_mass").is = 5.0;
    EXPECT_EQ(told(stated), "");
}

TEST(NoVolume, OfSeveralBodiesTheirNumberIsTold)
{
    TriMesh sheet = geometry::grid(1, 1, 1, 1), box = geometry::box({1, 1, 1}, {1, 1, 1});
    for (auto& p : sheet.positions) p.y() += 2;
    TriMesh other = sheet;
    for (auto& p : other.positions) p.y() += 1;
    const std::array<const TriMesh*, 3> all{&box, &sheet, &other};
    NodeRun node = cubes_node(geometry::merge(all), "each");
    EXPECT_NE(told(node).find("2 of 3 bodies enclose no volume: they weigh 4 kg"),
              std::string::npos)
        << told(node);
    // As one body it weighs what the box does: what min_fill adds is taken from all cubes.
    NodeRun one = cubes_node(geometry::merge(all), "merge");
    EXPECT_EQ(told(one), "");
}

// A slab that fills its cubes to min_fill just so, or to less.
TEST(NoVolume, AThinSolidIsNotTold)
{
    for (const double fill : {0.1, 0.2}) {
        NodeRun node = cubes_node(geometry::box({1, 0.01, 1}, {1, 1, 1}), "merge");
        node.param("min_fill").is = fill;
        EXPECT_EQ(told(node), "") << fill;
    }
}

}  // namespace
