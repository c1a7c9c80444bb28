#include "geometry/cubes/assign_matter.hpp"

#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::assign_matter;
using geometry::Matter;
using geometry::MatterRule;
using geometry::TriMesh;

TEST(AssignMatter, PatternsMatchAsInAShell)
{
    EXPECT_TRUE(geometry::matches("cable_left", "cable*"));
    EXPECT_TRUE(geometry::matches("cable_left", "*le?t"));
    EXPECT_TRUE(geometry::matches("", "*"));
    EXPECT_TRUE(geometry::matches("aXbXc", "a*X*c"));
    EXPECT_FALSE(geometry::matches("cable", "cables"));
    EXPECT_FALSE(geometry::matches("cable", "c?ble?"));
    EXPECT_FALSE(geometry::matches("", "?"));
    EXPECT_FALSE(geometry::matches(std::string(5000, 'a'), "*a*a*a*a*a*a*b"));  // no blow-up
}

MatterRule rule(MatterRule::Match match, const std::string& name, double young)
{
    MatterRule r;
    r.match = match;
    r.name = name;
    r.matter.name = name;
    r.matter.young = young;
    return r;
}

TriMesh two_materials()
{
    TriMesh mesh = test_meshes::box({0, 0, 0}, {1, 1, 1});
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    topology->materials = {{.name = "steel"}, {.name = "rubber", .colour = {1, 0, 0}}};
    topology->material = {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1};
    mesh.topology = topology;
    return mesh;
}

TEST(AssignMatter, TheLastRuleThatMatchesWins)
{
    const TriMesh mesh = two_materials();
    const std::vector<MatterRule> rules{rule(MatterRule::Match::all, "", 1),
                                        rule(MatterRule::Match::material, "rub*", 2),
                                        rule(MatterRule::Match::group, "nothing", 3)};
    const auto out = assign_matter(mesh, rules, {});
    ASSERT_EQ(out.matters.size(), 2u);  // the fallback is not in use
    EXPECT_EQ(out.matters[out.of(0)].young, 1);
    EXPECT_EQ(out.matters[out.of(11)].young, 2);
    EXPECT_EQ(out.idle, std::vector<std::size_t>{2});
    const auto reversed = assign_matter(mesh, std::vector{rules[1], rules[0]}, {});
    EXPECT_EQ(reversed.matters.size(), 1u);
    EXPECT_TRUE(reversed.face.empty());
    EXPECT_EQ(reversed.matters[0].young, 1);
}

TEST(AssignMatter, ColoursOfVerticesGoBeforeThoseOfMaterials)
{
    TriMesh mesh = two_materials();
    MatterRule red = rule(MatterRule::Match::colour, "", 7);
    red.colour = {1, 0.05f, 0};
    const auto by_material = assign_matter(mesh, std::vector{red}, {});
    EXPECT_EQ(by_material.matters[by_material.of(11)].young, 7);
    EXPECT_EQ(by_material.matters[by_material.of(0)].young, Matter{}.young);
    mesh.colours.assign(8, {0, 0, 1});
    EXPECT_EQ(assign_matter(mesh, std::vector{red}, {}).idle.size(), 1u);
}

TEST(AssignMatter, RejectsMatterThatCannotBe)
{
    const TriMesh mesh = two_materials();
    EXPECT_THROW(assign_matter(mesh, {}, {.density = 0}), std::invalid_argument);
    EXPECT_THROW(assign_matter(mesh, {}, {.young = std::nan("")}), std::invalid_argument);
    EXPECT_THROW(assign_matter(mesh, {}, {.poisson = 0.5}), std::invalid_argument);
    EXPECT_THROW(assign_matter(mesh, {}, {.mass_damping = -1}), std::invalid_argument);
    EXPECT_EQ(assign_matter({}, {}, {}).matters.size(), 1u);
}

}  // namespace
