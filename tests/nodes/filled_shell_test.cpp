// What Voxelize and Sample say of open meshes that they fill up to their rim.

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/cut_meshes.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;

// A ball of 0.5 m without the faces whose middle lies above a height.
TriMesh ball_up_to(float height)
{
    return test_meshes::cut_above(geometry::uv_sphere(0.5, 32, 16), height);
}

std::string warnings_of(const TriMesh& mesh, const std::string& method, double thickness)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("method").is = method;
    node.param("size").is = 0.1;
    node.param("thickness").is = thickness;
    node.run();
    std::string all;
    for (const auto& text : node.warnings) all += text + "\n";
    return all;
}

bool tells_of_hole(const TriMesh& mesh, double thickness = 0)
{
    return warnings_of(mesh, "solid", thickness).find("the mesh is open") != std::string::npos;
}

TEST(FilledShell, ABowlThatIsFilledToItsRimIsTold)
{
    const std::string text = warnings_of(ball_up_to(0), "solid", 0);
    EXPECT_NE(text.find("a hole 1 m across at (0, 0, 0)"), std::string::npos) << text;
    EXPECT_NE(text.find("(0.26 m^3)"), std::string::npos) << text;  // 2/3 pi r^3 = 0.26
    EXPECT_NE(text.find("method = surface and its thickness"), std::string::npos) << text;
    const std::string thick = warnings_of(ball_up_to(0), "solid", 0.02);
    EXPECT_NE(thick.find("although thickness = 0.02 m"), std::string::npos) << thick;
    EXPECT_EQ(warnings_of(ball_up_to(0), "surface", 0.1).find("is open"), std::string::npos);
    // A vase with a neck of 0.27 of its diameter: its thickness says that it is no solid.
    EXPECT_TRUE(tells_of_hole(ball_up_to(0.47f), 0.02));
}

// A box of 1 m by the places of its corners.
TriMesh box_with(const std::vector<std::array<std::uint32_t, 4>>& faces)
{
    std::vector<geometry::Vec3f> places;
    for (unsigned a = 0; a < 8; ++a) {
        places.emplace_back(float(a & 1), float(a >> 1 & 1), float(a >> 2 & 1));
    }
    std::vector<geometry::Triangle> triangles;
    for (const auto& [a, b, c, d] : faces) {
        triangles.push_back({a, b, c});
        triangles.push_back({a, c, d});
    }
    return test_meshes::mesh_of(places, triangles);
}

// Of six rays from a point no more than three meet a trough of three faces, or what is left of a
// box where a corner is at no place: none of them has an inside.
TEST(FilledShell, AMeshTooOpenToBeFilledIsTold)
{
    const auto tells = [](const TriMesh& mesh, double thickness) {
        const std::string text = warnings_of(mesh, "solid", thickness);
        return text.find("method = solid finds almost no inside") != std::string::npos;
    };
    const std::vector<std::array<std::uint32_t, 4>> faces = {
        {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {7, 3, 2, 6}, {7, 5, 1, 3}, {0, 4, 6, 2}};
    const TriMesh trough = box_with({faces[0], faces[1], faces[2]});
    EXPECT_TRUE(tells(trough, 0));
    EXPECT_FALSE(tells(trough, 0.02));  // it is a shell
    // A closed box beside it has an inside, which is not that of the trough. One around it has it.
    const TriMesh around = geometry::box({4, 4, 4}, geometry::Vec3i::Ones());
    TriMesh beside = geometry::box({1, 1, 1}, geometry::Vec3i::Ones());
    for (auto& p : beside.positions) p.x() += 3;
    EXPECT_TRUE(tells(test_meshes::both(trough, beside), 0));
    EXPECT_FALSE(tells(test_meshes::both(trough, around), 0));
    TriMesh box = box_with(faces);
    EXPECT_FALSE(tells(box, 0));
    // Two halves that only together have an inside.
    EXPECT_FALSE(tells(test_meshes::both(trough, box_with({faces[3], faces[4], faces[5]})), 0));
    box.positions[7].x() = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(tells(box, 0));
    EXPECT_FALSE(tells(ball_up_to(0), 0));
}

TEST(FilledShell, SampleTellsOfABowlWhoseInsideItFills)
{
    NodeRun node("Sample");
    node.inputs["mesh"] = {graph::Value::of(ball_up_to(0))};
    node.param("count").is = std::int64_t{100};
    node.run();
    EXPECT_TRUE(node.warnings.empty());  // points on its faces
    node.param("where").is = std::string("volume");
    node.run();
    ASSERT_EQ(node.warnings.size(), 1u);
    const std::string& text = node.warnings[0];
    EXPECT_NE(text.find("where = volume fills it up to the rim (0.26 m^3)"), std::string::npos);
    EXPECT_NE(text.find("set where = surface and its thickness"), std::string::npos) << text;
    node.warnings.clear();
    node.inputs["mesh"] = {graph::Value::of(ball_up_to(1))};  // all of it
    node.run();
    EXPECT_TRUE(node.warnings.empty());
}

// A lampshade on its pole.
TEST(FilledShell, AHoleWithAPoleThroughItsMiddleIsTold)
{
    const TriMesh bowl = ball_up_to(0);
    for (const double height : {0.3, 3.0}) {  // into the bowl, and through its bottom
        TriMesh pole = geometry::box({0.1, height, 0.1}, geometry::Vec3i::Ones());
        EXPECT_TRUE(tells_of_hole(test_meshes::both(bowl, pole))) << height;
        EXPECT_TRUE(tells_of_hole(test_meshes::both(bowl, pole), 0.02)) << height;
    }
    // A block that fills most of the hole is a lid.
    const TriMesh plug = geometry::box({0.8, 0.1, 0.8}, geometry::Vec3i::Ones());
    EXPECT_FALSE(tells_of_hole(test_meshes::both(bowl, plug)));
}

TEST(FilledShell, SmallHolesLidsAndSheetsAreNot)
{
    EXPECT_FALSE(tells_of_hole(ball_up_to(0.47f)));
    // A lid a little above the rim, larger than it.
    TriMesh lid = geometry::grid(1.1, 1.1, 1, 1);
    for (auto& p : lid.positions) p.y() += 0.02f;
    const TriMesh bowl = ball_up_to(0);
    EXPECT_FALSE(tells_of_hole(test_meshes::both(bowl, lid)));
    // A bowl of 0.26 m^3 that stands on a block of 27 m^3.
    TriMesh block = geometry::box({3, 3, 3}, geometry::Vec3i::Ones());
    for (auto& p : block.positions) p.y() -= 2.1f;
    EXPECT_FALSE(tells_of_hole(test_meshes::both(bowl, block)));
    TriMesh waves = geometry::grid(2, 2, 40, 40);
    for (auto& p : waves.positions) p.y() = 0.1f * std::sin(6 * p.x());
    EXPECT_FALSE(tells_of_hole(waves));
    EXPECT_FALSE(tells_of_hole(waves, 0.02));
}

}  // namespace
