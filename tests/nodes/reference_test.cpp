#include "graph/tools/reference.hpp"
#include "graph/tools/schema.hpp"

#include "nodes/distances.hpp"
#include "nodes/registry.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <sstream>

TEST(Distances, AreOfMeshesWithTheSameVertices)
{
    geometry::TriMesh mesh, moved;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    moved = mesh;
    moved.positions[2].z() = 3;
    const auto distance = [](const geometry::TriMesh& a, const geometry::TriMesh& b) {
        return nodes::distances().at("mesh")(graph::Value::of(geometry::TriMesh(a)),
                                             graph::Value::of(geometry::TriMesh(b)));
    };
    EXPECT_DOUBLE_EQ(distance(mesh, moved), 1.5);  // sqrt(9 / 4)
    moved.positions.pop_back();
    try {
        distance(mesh, moved);
        FAIL();
    } catch (const std::invalid_argument& error) {
        EXPECT_EQ(std::string(error.what()).find("the mesh has 4 vertices, the reference has 3:"),
                  0u);
    }
}

TEST(Reference, ThePageMatchesTheDescriptions)
{
    std::ifstream in(ASPIC_SOURCE_DIR "/docs/nodes.md");
    std::ostringstream page;
    page << in.rdbuf();
    EXPECT_TRUE(page.str() == graph::reference_page(nodes::registry()))
        << "docs/nodes.md is out of date: ./aspic nodes --markdown > docs/nodes.md";
}

TEST(Schema, KnowsTheShortFormsOfTheSizeOfCubes)
{
    const auto schema = nlohmann::json::parse(graph::schema_text(nodes::registry()));
    for (const auto& type : schema["definitions"]["node"]["allOf"]) {
        const std::string pattern = type["if"]["properties"]["type"]["pattern"];
        if (!pattern.starts_with("^Voxelize(")) continue;
        const auto& size = type["then"]["properties"]["params"]["properties"]["size"];
        EXPECT_EQ(size["anyOf"][0]["type"], "number");
        const auto& forms = size["anyOf"].back()["anyOf"];
        EXPECT_EQ(forms[0]["enum"], nlohmann::json::array({"draft", "good", "exact"}));
        EXPECT_EQ(forms[1]["properties"]["auto"]["required"], nlohmann::json::array({"error"}));
        return;
    }
    FAIL() << "no Voxelize";
}
