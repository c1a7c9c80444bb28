// Pieces of one mesh that touch, and are bodies of their own.

#include "geometry/cubes/components.hpp"
#include "geometry/mesh/pieces.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace {

using fixtures::NodeRun;
using graph::Value;
using Vector = std::array<double, 3>;

constexpr double edge = 0.3;  // m

// Three boxes, one on top of the other. Their faces meet within cubes of 0.1 m that begin at
// y = -0.5, or where these meet.
Value tower()
{
    NodeRun box("Primitive");
    box.param("shape").is = std::string("box");
    box.param("box.size").is = Vector{edge, edge, edge};
    NodeRun copies("Copies");
    copies.inputs["mesh"] = {box.run()};
    copies.param("count_x").is = std::int64_t{1};
    copies.param("count_y").is = std::int64_t{3};
    copies.param("count_z").is = std::int64_t{1};
    copies.param("step").is = Vector{edge, edge, edge};
    return copies.run();
}

NodeRun voxelize(const Value& mesh, const std::string& pieces, double lowest = -0.47)
{
    NodeRun out("Voxelize");
    out.inputs["mesh"] = {mesh};
    out.param("method").is = std::string("solid");
    out.param("pieces").is = pieces;
    out.param("size").is = 0.1;
    out.param("align").is = std::string("origin");
    out.param("origin").is = Vector{-0.15, lowest, -0.15};
    out.param("matter.young").is = 1e6;
    return out;
}

std::size_t bodies_of(const Value& cubes)
{
    return find_components(*cubes.as<geometry::Cubes>(), geometry::Connectivity::corner).count();
}

// The mean of each piece of the mesh, as the body carries it.
std::vector<geometry::Vec3> middles(const Value& mesh, const Value& cubes, const Value& state)
{
    NodeRun embed("Embed");
    embed.inputs["mesh"] = {mesh};
    embed.inputs["cubes"] = {cubes};
    embed.inputs["state"] = {state};
    const auto moved = embed.run().as<geometry::TriMesh>();
    const std::size_t piece = moved->positions.size() / 3;
    std::vector<geometry::Vec3> out(3, geometry::Vec3::Zero());
    for (std::size_t v = 0; v < 3 * piece; ++v) {
        out[v / piece] += moved->positions[v].cast<double>() / double(piece);
    }
    return out;
}

// Two boxes of one file, the one on the other.
Value boxes_of_a_file(const files::Folder& folder, const std::string& weld)
{
    std::string obj;
    for (int box = 0; box < 2; ++box) {
        obj += fmt::format("o box{}\n", box);
        for (int v = 0; v < 8; ++v) {
            obj += fmt::format("v {} {} {}\n", 0.3 * (v & 1) - 0.15, 0.3 * (((v >> 1) & 1) + box),
                               0.3 * (v >> 2) - 0.15);
        }
        for (const auto& f : std::initializer_list<std::array<int, 4>>{{1, 3, 4, 2},
                                                                       {5, 6, 8, 7},
                                                                       {1, 2, 6, 5},
                                                                       {3, 7, 8, 4},
                                                                       {1, 5, 7, 3},
                                                                       {2, 4, 8, 6}}) {
            obj += "f";
            for (const int v : f) obj += fmt::format(" {}", v + 8 * box);
            obj += "\n";
        }
    }
    NodeRun read("ReadMesh");
    read.param("path").is = folder.write("boxes.obj", obj).string();
    read.param("weld").is = weld;
    return read.run();
}

TEST(SeparateBodies, OfOneFileAreWeldedUnlessItsGroupsStayApart)
{
    const files::Folder folder;
    for (const std::string pieces : {"each", "groups"}) {
        NodeRun welded = voxelize(boxes_of_a_file(folder, "all"), pieces, 0);
        EXPECT_EQ(bodies_of(welded.run()), 1u);
        ASSERT_EQ(welded.warnings.size(), 1u);
        EXPECT_EQ(welded.warnings[0].substr(0, 9), pieces == "each" ? "2 groups," : "2 groups ");
        EXPECT_NE(welded.warnings[0].find("weld = groups"), std::string::npos);
        NodeRun apart = voxelize(boxes_of_a_file(folder, "groups"), pieces, 0);
        EXPECT_EQ(bodies_of(apart.run()), 2u);
        EXPECT_TRUE(apart.warnings.empty()) << apart.warnings[0];
    }
}

TEST(SeparateBodies, BoxesThatTouchAreOneBodyOrEachItsOwn)
{
    const Value mesh = tower();
    for (const double lowest : {-0.47, -0.45}) {
        EXPECT_EQ(bodies_of(voxelize(mesh, "merge", lowest).run()), 1u);
        NodeRun each = voxelize(mesh, "each", lowest);
        const Value cubes = each.run();
        EXPECT_EQ(bodies_of(cubes), 3u);
        EXPECT_TRUE(each.warnings.empty()) << each.warnings[0];
        EXPECT_NEAR(total_mass(*cubes.as<geometry::Cubes>()), 3000 * edge * edge * edge, 1e-4);
    }
}

TEST(SeparateBodies, TheTopOfATowerSlidesOffItsHeldFoot)
{
    // The lowest box is held. Without friction the others slide on it by a t^2 / 2, with a = 3
    // m/s^2, and stay on top of each other.
    const Value mesh = tower();
    for (const double lowest : {-0.47, -0.45}) {
        const Value cubes = voxelize(mesh, "each", lowest).run();
        NodeRun pin("Pin");
        pin.inputs["cubes"] = {cubes};
        pin.param("where").is = std::string("ends");
        pin.param("ends.axis").is = std::string("y");
        pin.param("ends.end").is = std::string("low");
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        simulate.inputs["surface"] = {mesh};
        simulate.inputs["pins"] = {pin.run()};
        simulate.param("gravity").is = Vector{3, -9.81, 0};
        simulate.param("contact.friction").is = 0.0;
        Value state = simulate.run();
        const auto before = middles(mesh, cubes, state);
        for (int frame = 2; frame <= 6; ++frame) {
            simulate.previous = {state};
            state = simulate.run(frame);
        }
        EXPECT_TRUE(simulate.warnings.empty()) << simulate.warnings[0];
        const auto after = middles(mesh, cubes, state);
        const double t = 5 / 24.0, slid = 0.5 * 3 * t * t;
        EXPECT_NEAR(after[0].x() - before[0].x(), 0, 0.002);
        for (const std::size_t k : {1u, 2u}) {
            EXPECT_NEAR(after[k].x() - before[k].x(), slid, 0.3 * slid) << k;
            EXPECT_NEAR(after[k].y() - before[k].y(), 0, 0.005) << k;
        }
    }
}

TEST(SeparateBodies, TotalMassIsThatOfAllTogether)
{
    NodeRun each = voxelize(tower(), "each");
    each.param("total_mass").is = 12.0;
    EXPECT_NEAR(total_mass(*each.run().as<geometry::Cubes>()), 12, 1e-9);
}

TEST(SeparateBodies, TooManyCubesAreToldWithTheBodyThatIsOneTooMany)
{
    NodeRun each = voxelize(tower(), "each");
    each.param("max_cubes").is = std::int64_t{70};
    try {
        each.run();
        FAIL() << "expected an error";
    } catch (const std::invalid_argument& error) {
        EXPECT_EQ(std::string(error.what()).find("the first 2 of 3 bodies have"), 0u)
            << error.what();
    }
}

TEST(SeparateBodies, CopiesWithGroupsOfTheirOwnAreBodies)
{
    // Two pieces a copy, which overlap.
    NodeRun box("Primitive"), ball("Primitive"), merge("Merge"), copies("Copies");
    box.param("shape").is = std::string("box");
    box.param("box.size").is = Vector{edge, edge, edge};
    ball.param("shape").is = std::string("sphere");
    ball.param("sphere.radius").is = 0.2;
    merge.inputs["meshes"] = {box.run(), ball.run()};
    copies.inputs["mesh"] = {merge.run()};
    copies.param("count_x").is = std::int64_t{2};
    copies.param("count_z").is = std::int64_t{1};
    copies.param("step").is = Vector{0.4, 1, 1};
    EXPECT_EQ(bodies_of(voxelize(copies.run(), "each").run()), 4u);
    EXPECT_EQ(bodies_of(voxelize(copies.run(), "groups").run()), 1u);
    copies.param("number_groups").is = true;
    EXPECT_EQ(bodies_of(voxelize(copies.run(), "groups").run()), 2u);
}

// Boxes that meet at y = -0.15, in the cell from -0.17 to -0.07: 0.02 m of the lower one in it,
// 0.08 m of the upper one.
TEST(SeparateBodies, OfTwoAtAPointTheOneWithMoreMaterialThereIsKept)
{
    const Value cubes = voxelize(tower(), "each").run();
    NodeRun component("ConnectedComponent");
    component.inputs["cubes"] = {cubes};
    component.param("keep").is = std::string("point");
    const auto lowest_kept = [&](double y) {
        component.warnings.clear();
        component.param("point").is = Vector{0, y, 0};
        const auto kept = component.run().as<geometry::Cubes>();
        double lowest = 1;
        for (std::size_t k = 0; k < kept->corner_count(); ++k) {
            lowest = std::min(lowest, kept->corner_position(k).y());
        }
        return lowest;
    };
    const auto told = [&] {
        return std::any_of(
            component.warnings.begin(), component.warnings.end(),
            [](const std::string& w) { return w.find("several bodies") != std::string::npos; });
    };
    EXPECT_NEAR(lowest_kept(-0.1), -0.17, 1e-6);
    EXPECT_TRUE(told());
    EXPECT_NEAR(lowest_kept(0), -0.17, 1e-6);
    EXPECT_FALSE(told());
}

}  // namespace
