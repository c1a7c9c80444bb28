#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

namespace {

using fixtures::Scene;
using geometry::TriMesh;

const std::string tree = "usemtl bark\no trunk\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
                         "usemtl green\no leaf 1\nv 2 0 0\nv 3 0 0\nv 2 1 0\nf 4 5 6\n"
                         "o leaf 2\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 7 8 9\n";
const std::string library = "newmtl bark\nKd 0.3 0.2 0.1\nnewmtl green\nKd 0 1 0\n";

Scene scene_with(const files::Folder& folder, const std::string& parts)
{
    folder.write("tree.mtl", library);
    folder.write("tree.obj", "mtllib tree.mtl\n" + tree);
    return Scene(R"("read": { "type": "ReadMesh@1", "params": { "path": "tree.obj" } },
        "split": { "type": "Split@1", "inputs": { "mesh": "read.mesh" },
                   "params": { "parts": )" +
                     parts + R"( } },
        "rest": { "type": "Merge@1", "inputs": { "meshes": ["split.rest"] } })",
                 folder.path, 1);
}

std::vector<std::string> groups_of(const TriMesh& mesh)
{
    return mesh.topology->groups;
}

TEST(SplitNodes, PartsAreTakenByTheNamesOfGroupsOrMaterials)
{
    using Names = std::vector<std::string>;
    const files::Folder folder;
    const auto expect = [&](const std::string& parts, const Names& taken, const Names& left) {
        SCOPED_TRACE(parts);
        Scene scene = scene_with(folder, parts);
        EXPECT_EQ(groups_of(*scene.at<TriMesh>("split")), taken);
        EXPECT_EQ(groups_of(*scene.at<TriMesh>("rest")), left);
    };
    expect(R"([{ "name": "leaf*" }])", {"leaf 1", "leaf 2"}, {"trunk"});
    expect(R"([{ "name": "green" }])", {"leaf 1", "leaf 2"}, {"trunk"});
    expect(R"([{ "name": "green", "match": "material" }])", {"leaf 1", "leaf 2"}, {"trunk"});
    expect(R"([{ "name": "trunk" }, { "name": "leaf ?" }])", {"trunk", "leaf 1", "leaf 2"}, {});
    expect(R"([{ "name": "leaf 2" }])", {"leaf 2"}, {"trunk", "leaf 1"});
}

TEST(SplitNodes, ANameThatMatchesNothingIsToldWithTheNamesThatThereAre)
{
    const files::Folder folder;
    Scene scene =
        scene_with(folder, R"([{ "name": "leafs" }, { "name": "bark", "match": "group" }])");
    EXPECT_TRUE(scene.at<TriMesh>("split")->triangles().empty());
    EXPECT_EQ(scene.at<TriMesh>("rest")->triangles().size(), 3u);
    ASSERT_GE(scene.warnings.size(), 2u);
    EXPECT_EQ(scene.warnings[0],
              "parts[0].name \"leafs\" matches no group or material of the mesh: "
              "it has bark, green, leaf 1, leaf 2, trunk");
    EXPECT_EQ(scene.warnings[1], "parts[1].name \"bark\" matches no group of the mesh: it has "
                                 "leaf 1, leaf 2, trunk");
}

}  // namespace
