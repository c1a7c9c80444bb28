#include "geometry/mesh/merge.hpp"

#include "geometry/io/write_mesh.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

TEST(Merge, OfAnythingIsConsistentAndKeepsEveryFaceAndVertex)
{
    const auto all = meshes::sound();
    for (const auto& a : all) {
        for (const auto& b : all) {
            SCOPED_TRACE(a.name + " and " + b.name);
            TriMesh bare = b.mesh;  // one of them without normals
            bare.normals.clear();
            MeshTopology topology = *bare.topology;
            topology.normal_triangles.clear();
            bare.topology = std::make_shared<const MeshTopology>(topology);

            const std::array<const TriMesh*, 2> both{&a.mesh, &bare};
            const TriMesh mesh = merge(both);
            meshes::expect_consistent(mesh);
            EXPECT_EQ(mesh.positions.size(), a.mesh.positions.size() + b.mesh.positions.size());
            EXPECT_EQ(mesh.triangles().size(),
                      a.mesh.triangles().size() + b.mesh.triangles().size());
            EXPECT_EQ(mesh.topology->normal_triangles.size(), mesh.triangles().size());
        }
    }
}

TEST(Merge, EqualMaterialsAndGroupsBecomeOne)
{
    const Material red{"red", {1, 0, 0}}, other_red{"red", {0.9f, 0, 0}};
    const TriMesh a = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), red, "left");
    const TriMesh b = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), red, "right");
    const TriMesh c = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), other_red, "left");
    const std::array<const TriMesh*, 3> all{&a, &b, &c};
    const auto topology = merge(all).topology;
    ASSERT_EQ(topology->materials.size(), 2u);
    EXPECT_EQ(topology->groups, (std::vector<std::string>{"left", "right"}));
    EXPECT_EQ(topology->material[12], 0);
    EXPECT_EQ(topology->material[24], 1);
    EXPECT_EQ(topology->group[12], 1);
    EXPECT_EQ(topology->group[24], 0);
}

TEST(Merge, GroupsOfOneNameWithinAMeshStayDifferentOnes)
{
    const TriMesh a = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), {}, "crate");
    TriMesh two = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), {}, "crate");
    MeshTopology topology = *two.topology;
    topology.groups.emplace_back("crate");
    for (std::size_t f = 6; f < 12; ++f) topology.group[f] = 1;
    two.topology = std::make_shared<const MeshTopology>(topology);
    const std::array<const TriMesh*, 1> alone{&two};
    EXPECT_EQ(merge(alone).topology->group, topology.group);
    const std::array<const TriMesh*, 2> both{&two, &a};
    EXPECT_EQ(merge(both).topology->groups, topology.groups);
    const std::string text = obj_text(two, "");
    EXPECT_NE(text.find("o crate\n"), std::string::npos);
    EXPECT_NE(text.find("o crate.1\n"), std::string::npos);
}

TEST(Merge, MissingColoursAreThoseOfMaterialsAndMissingAttributesZero)
{
    TriMesh a = icosphere(1, 0), b = icosphere(1, 0);
    const TriMesh red = meshes::with_material(a, {"red", {0.8f, 0, 0}}, "");
    b.colours.assign(12, {0.5f, 0, 0});
    b.attributes = {{"speed", "m/s", std::vector<float>(12, 3.f)}};
    const std::array<const TriMesh*, 3> all{&a, &b, &red};
    const TriMesh mesh = merge(all);
    meshes::expect_consistent(mesh);
    EXPECT_EQ(mesh.colours[0], Material{}.colour);
    EXPECT_EQ(mesh.colours[12], Vec3f(0.5f, 0, 0));
    EXPECT_EQ(mesh.colours[24], Vec3f(0.8f, 0, 0));
    ASSERT_EQ(mesh.attributes.size(), 1u);
    EXPECT_EQ(mesh.attributes[0].values[0], 0);
    EXPECT_EQ(mesh.attributes[0].values[12], 3);
    EXPECT_EQ(mesh.attributes[0].values[24], 0);
}

TEST(Merge, OfNothingIsEmpty)
{
    const TriMesh mesh = merge({});
    EXPECT_TRUE(mesh.positions.empty());
    const TriMesh empty;
    const std::array<const TriMesh*, 2> two{&empty, &empty};
    EXPECT_TRUE(merge(two).triangles().empty());
}

}  // namespace
