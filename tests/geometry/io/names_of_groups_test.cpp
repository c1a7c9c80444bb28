// Objects of a file stay apart whatever they are named.

#include "geometry/io/assemble_mesh.hpp"
#include "geometry/io/read_mesh.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace geometry;
using Names = std::vector<std::string>;

const std::string legs = "o leg left\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
                         "o  leg \tright \r\nv 2 0 0\nv 3 0 0\nv 2 1 0\nf 4 5 6\n"
                         "o seat\nv 0 0 1\nv 1 0 1\nv 0 1 1\nf 7 8 9\n";

TEST(NamesOfGroups, ObjectsOfAnObjKeepTheBlanksInTheirNames)
{
    const files::Folder folder;
    const TriMesh mesh = read_mesh(folder.write("chair.obj", legs)).mesh;
    ASSERT_EQ(mesh.triangles().size(), 3u);
    EXPECT_EQ(mesh.topology->groups, (Names{"leg left", "leg  right", "seat"}));
    EXPECT_EQ(mesh.topology->group, (std::vector<std::uint16_t>{0, 1, 2}));
}

TEST(NamesOfGroups, AGroupOfAnObjThatComesAgainIsOne)
{
    const files::Folder folder;
    const std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\ng left\nf 1 2 3\n"
                             "g right\nf 1 2 4\ng left\nf 2 3 4\n";
    const TriMesh mesh = read_mesh(folder.write("two.obj", text)).mesh;
    EXPECT_EQ(mesh.topology->groups, (Names{"left", "right"}));
    EXPECT_EQ(std::count(mesh.topology->group.begin(), mesh.topology->group.end(), 0), 2);
}

ImportedScene scene_of(const std::vector<std::pair<std::string, std::uint32_t>>& nodes)
{
    ImportedScene scene;
    ImportedMesh mesh;
    mesh.name = "triangle";
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    scene.meshes = {mesh};
    scene.materials = {{"paint", {0.5f, 0.5f, 0.5f}}};
    double x = 0;
    for (const auto& [name, node] : nodes) {
        scene.nodes.push_back({name, 0, {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0}, node});
        x += 1;
    }
    return scene;
}

// glTF allows equal names. Meshes of one node are one object in several materials.
TEST(NamesOfGroups, NodesOfOneNameAreGroupsOfTheirOwnAndMeshesOfOneNodeAreOne)
{
    const auto topology =
        assemble_mesh(scene_of({{"leg", 1}, {"leg", 2}, {"leg", 2}})).mesh.topology;
    EXPECT_EQ(topology->groups, (Names{"leg", "leg"}));
    EXPECT_EQ(topology->group, (std::vector<std::uint16_t>{0, 1, 1}));
    ReadOptions options;
    options.weld = Weld::groups;
    EXPECT_EQ(assemble_mesh(scene_of({{"leg", 1}, {"leg", 2}}), options).mesh.positions.size(), 6u);
    EXPECT_EQ(assemble_mesh(scene_of({{"", 1}, {"", 2}})).mesh.topology->groups, Names{"triangle"});
}

}  // namespace
