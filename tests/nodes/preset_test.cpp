// Materials by name: what cubes and sheets get of them, and that the page tells the same numbers.

#include "geometry/cubes/known_matter.hpp"
#include "geometry/mesh/primitive.hpp"
#include "graph/document/document.hpp"
#include "tests/nodes/one_node.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace {

using fixtures::NodeRun;
using geometry::Cubes;
using geometry::KnownMatter;

TEST(Presets, GiveCubesAllNumbersOfTheMaterial)
{
    for (const KnownMatter& known : geometry::known_matters) {
        NodeRun node("Voxelize");
        node.inputs["mesh"] = {graph::Value::of(geometry::box({1, 1, 1}, {1, 1, 1}))};
        node.param("method").is = std::string("solid");
        node.param("size").is = 0.5;
        node.param("matter.preset").is = std::string(known.name);
        const graph::Value value = node.run();
        const Cubes& cubes = *value.as<Cubes>();
        ASSERT_EQ(cubes.count(), 8u);
        EXPECT_NEAR(geometry::total_mass(cubes), known.density, 1e-9 * known.density);
        EXPECT_DOUBLE_EQ(cubes.young[0], known.young) << known.name;
        EXPECT_DOUBLE_EQ(cubes.poisson[0], known.poisson) << known.name;
        EXPECT_EQ(cubes.matters.at(0).name, known.name);
        // The loss factor at 10 Hz: twice the damping ratio, beta omega.
        EXPECT_NEAR(cubes.stiffness_damping[0] * 62.8318530718, known.loss, 1e-9) << known.name;
    }
}

TEST(Presets, CustomKeepsTheNumbers)
{
    NodeRun node("Plane");
    const Cubes sheet = *node.run().as<Cubes>();
    EXPECT_EQ(sheet.young.at(0), 1e6);
    EXPECT_EQ(sheet.matters.at(0).density, 1000);
    node.param("matter.preset").is = std::string("leather");
    EXPECT_EQ(node.run().as<Cubes>()->young.at(0), 0.2e9);
}

TEST(Presets, ANameInThePlaceOfTheBlockIsToldWhereItBelongs)
{
    const auto loaded = graph::load_text(
        R"({ "aspic": 1, "nodes": { "sheet": { "type": "Plane@1",
             "params": { "matter": "rubber" } } } })",
        "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_EQ(loaded.problems[0].suggestion, R"(did you mean {"preset": "rubber"}?)");
}

TEST(Presets, AreOnThePageOfMaterials)
{
    std::ifstream file(ASPIC_SOURCE_DIR "/docs/materials.md");
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    for (const KnownMatter& m : geometry::known_matters) {
        const std::string row = fmt::format("| {} | {:.4g} | {:.4g} | {:.4g} | {:.4g} | ", m.name,
                                            m.density, m.young, m.poisson, m.loss);
        EXPECT_NE(page.find(row), std::string::npos) << row;
        // A solid that is stable, and softer than diamond.
        EXPECT_GE(m.poisson, 0);
        EXPECT_LT(m.poisson, 0.5);
        EXPECT_LT(m.young, 1.2e12);
    }
}

TEST(Presets, AYoungsModulusThatNoSolidHasIsDoubted)
{
    for (const auto& [young, doubted] :
         {std::pair{0.03, true}, {5000.0, false}, {2e11, false}, {2e14, true}}) {
        NodeRun voxelize("Voxelize");
        voxelize.inputs["mesh"] = {
            graph::Value::of(geometry::box({0.2, 0.2, 0.2}, geometry::Vec3i::Ones()))};
        voxelize.param("method").is = std::string("solid");
        voxelize.param("size").is = 0.1;
        voxelize.param("matter.young").is = young;
        voxelize.run();
        ASSERT_EQ(voxelize.warnings.size(), doubted ? 1u : 0u) << young;
        EXPECT_EQ(doubted && voxelize.warnings[0].find("another unit") != std::string::npos,
                  doubted);
    }
}

}  // namespace
