// The node Sheet, and what other nodes make of its cells.

#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using fixtures::NodeRun;
using geometry::Cubes;
using geometry::TriMesh;
using geometry::Vec3;

NodeRun sheet_node(const TriMesh& mesh)
{
    NodeRun out("Sheet");
    out.inputs["mesh"] = {graph::Value::of(mesh)};
    out.param("thickness").is = 0.01;
    out.param("matter.density").is = 1000.0;
    out.param("matter.young").is = 1e6;
    out.param("matter.poisson").is = 0.3;
    return out;
}

// 1 m by 0.2 m, of irregular triangles, with a row beside it at x < 0.
TriMesh long_strip()
{
    return fixtures::squares({19, 2, 0.05, fixtures::Cut::random, 0.3, 1});
}

std::string refusal_of(NodeRun& node)
{
    try {
        node.run();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "nothing was refused";
}

NodeRun pin_where(const Cubes& cubes, const char* where)
{
    NodeRun out("Pin");
    out.inputs["cubes"] = {graph::Value::of(cubes)};
    out.param("where").is = std::string(where);
    return out;
}

std::size_t pinned(NodeRun& node)
{
    return node.run().as<physics::Pins>()->corner.size();
}

}  // namespace

TEST(SheetNode, AStripOfTrianglesSagsByItsWeightAndIsCarriedByEmbed)
{
    // Clamped at x = 0: q L^4 / (8 E I) = 12 rho g L^4 / (8 E h^2) at 1 m.
    const TriMesh mesh = long_strip();
    NodeRun sheet = sheet_node(mesh);
    const auto made = sheet.outputs();
    EXPECT_TRUE(sheet.warnings.empty());
    NodeRun pin = pin_where(*made[0].as<Cubes>(), "box");
    pin.param("box.centre").is = std::array<double, 3>{-1 + 1e-6, 0, 0};
    pin.param("box.size").is = std::array<double, 3>{2, 4, 4};
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {made[0]};
    simulate.inputs["pins"] = {pin.run()};
    simulate.param("method").is = std::string("shell");
    simulate.param("gravity").is = std::array<double, 3>{0, -1e-3, 0};
    simulate.param("dt").is = 1000.0;  // it is at rest then
    simulate.param("step.tolerance").is = 1e-8;
    simulate.previous = simulate.outputs(1);
    NodeRun embed("Embed");
    embed.inputs["mesh"] = {made[1]};
    embed.inputs["cubes"] = {made[0]};
    embed.inputs["state"] = {simulate.outputs(2)[0]};
    const graph::Value carried = embed.run();
    EXPECT_TRUE(embed.warnings.empty());
    double lowest = 0;
    for (const auto& p : carried.as<TriMesh>()->positions) lowest = std::min(lowest, double(p.y()));
    const double expected = 12 * 1000 * 1e-3 / (8 * 1e6 * 1e-4);
    EXPECT_NEAR(-lowest, expected, 0.05 * expected);
}

TEST(SheetNode, TellsFacesThatItLeavesOutAndEdgesOfThree)
{
    TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0.5f}, {-1, 0, 0.5f}, {0, 1, 0.5f}};
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}, {0, 2, 1}};
    mesh.topology = topology;
    NodeRun sheet = sheet_node(mesh);
    sheet.run();
    ASSERT_EQ(sheet.warnings.size(), 2u);
    EXPECT_NE(sheet.warnings[0].find("1 of 4 triangles lies on another one"), std::string::npos);
    EXPECT_NE(sheet.warnings[1].find("1 edges have more than two faces"), std::string::npos);
}

TEST(SheetNode, OtherMethodsSayWhatToUse)
{
    NodeRun sheet = sheet_node(long_strip());
    const graph::Value cubes = sheet.run();
    for (const char* method : {"bricks", "springs", "lattice"}) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        simulate.param("method").is = std::string(method);
        EXPECT_NE(refusal_of(simulate).find("use method shell"), std::string::npos) << method;
    }
    NodeRun points = sheet_node([] {
        TriMesh out;
        out.positions = {{0, 0, 0}, {1, 0, 0}};
        return out;
    }());
    EXPECT_NE(refusal_of(points).find("needs a mesh with faces"), std::string::npos);
}

TEST(SheetNode, PinsFindItsRimItsEndsAndWhatAMeshFollows)
{
    const TriMesh mesh = fixtures::squares({4, 3, 0.1});
    NodeRun sheet = sheet_node(mesh);
    const Cubes cubes = *sheet.run().as<Cubes>();
    NodeRun rim = pin_where(cubes, "rim");
    EXPECT_EQ(pinned(rim), 14u);
    NodeRun ends = pin_where(cubes, "ends");
    ends.param("ends.axis").is = std::string("x");
    ends.param("ends.end").is = std::string("high");
    ends.param("ends.layers").is = std::int64_t{0};
    EXPECT_EQ(pinned(ends), 4u);
    TriMesh moved = mesh;
    for (auto& p : moved.positions) p.y() += 0.5f;
    ends.inputs["follow"] = {graph::Value::of(moved)};
    const graph::Value pins = ends.run();
    for (const Vec3& target : pins.as<physics::Pins>()->target) EXPECT_NEAR(target.y(), 0.5, 1e-6);
}

TEST(SheetNode, PinsOfACutSheetFollowItsCubeMesh)
{
    const TriMesh mesh = fixtures::squares({1, 1, 0.4});
    NodeRun sheet = sheet_node(mesh);
    sheet.param("longest_side").is = 0.15;
    const Cubes cubes = *sheet.run().as<Cubes>();
    NodeRun rim = pin_where(cubes, "rim");
    rim.inputs["follow"] = {graph::Value::of(mesh)};
    EXPECT_NE(refusal_of(rim).find("or that of CubeMesh"), std::string::npos);
    NodeRun of_cubes("CubeMesh");
    of_cubes.inputs["cubes"] = {graph::Value::of(cubes)};
    TriMesh moved = *of_cubes.run().as<TriMesh>();
    for (auto& p : moved.positions) p.y() += 0.5f;
    rim.inputs["follow"] = {graph::Value::of(moved)};
    const graph::Value value = rim.run();
    const physics::Pins& pins = *value.as<physics::Pins>();
    EXPECT_EQ(pins.corner.size(), 16u);
    for (std::size_t i = 0; i < pins.corner.size(); ++i) {
        const Vec3 rest = cubes.corner_position(pins.corner[i]);
        EXPECT_LT((pins.target[i] - rest - Vec3(0, 0.5, 0)).norm(), 1e-6);
    }
}

TEST(SheetNode, EmbedWarnsOfAMeshThatIsFarOff)
{
    const TriMesh mesh = fixtures::squares({4, 3, 0.1});
    NodeRun sheet = sheet_node(mesh);
    TriMesh other = mesh;
    for (auto& p : other.positions) p.y() += 2;
    NodeRun embed("Embed");
    const graph::Value cubes = sheet.run();
    physics::State state;
    state.x = geometry::corner_positions(*cubes.as<Cubes>());
    embed.inputs["mesh"] = {graph::Value::of(other)};
    embed.inputs["cubes"] = {cubes};
    embed.inputs["state"] = {graph::Value::of(state)};
    embed.run();
    ASSERT_EQ(embed.warnings.size(), 1u);
    EXPECT_NE(embed.warnings[0].find("lies up to 2 m from the sheet"), std::string::npos);
}
