// Documents as they were once written, kept in old/: they load to what they meant then. Each is the
// first version of a scene in graphs/; bridge and chair_drop were written for Sample@1, those with
// skeletons for ImplicitLayer@1.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace {

namespace fs = std::filesystem;

const fs::path folder = fs::path(ASPIC_SOURCE_DIR) / "tests/nodes/old";

// The parameter of a node, blocks by dots: "volume.derivative".
const graph::ParamValue& param(const graph::Graph& g, const std::string& node, std::string path)
{
    const auto found = std::find_if(g.nodes.begin(), g.nodes.end(),
                                    [&](const graph::Node& n) { return n.name == node; });
    if (found == g.nodes.end()) throw std::logic_error("no node " + node);
    const std::vector<graph::Param>* described = &found->type->params;
    const graph::ParamValues* values = &found->params;
    for (;;) {
        const std::string name = path.substr(0, path.find('.'));
        std::size_t i = 0;
        while (described->at(i).name != name) ++i;
        if (name == path) return values->at(i);
        path = path.substr(name.size() + 1);
        values = &std::get<graph::ParamValues>(values->at(i).is);
        described = &described->at(i).children;
    }
}

double number(const graph::ParamValue& value)
{
    return std::get<double>(value.is);
}

graph::Loaded load(const std::string& nodes)
{
    return graph::load_text(R"({ "aspic": 1, "nodes": {
        "ball": { "type": "Primitive@1" }, )" +
                                nodes + "} }",
                            "old.json", nodes::registry());
}

TEST(OldFiles, AllLoadAndReportTheirUpgradesOnly)
{
    std::map<std::string, std::size_t> notes;
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() != ".json") continue;
        const graph::Loaded loaded = graph::load_file(entry.path(), nodes::registry());
        EXPECT_TRUE(loaded.ok()) << entry.path();
        EXPECT_FALSE(loaded.graph.nodes.empty()) << entry.path();
        for (const graph::Problem& p : loaded.problems) {
            EXPECT_EQ(p.severity, graph::Severity::note) << graph::describe(p);
            EXPECT_NE(p.message.find("is read as"), std::string::npos) << graph::describe(p);
        }
        notes[entry.path().stem()] = loaded.problems.size();
    }
    EXPECT_EQ(notes.size(), 8u);
    EXPECT_EQ(notes["bridge"], 6u);  // a Sample, a Simulate twice, an Embed twice, a Render
    EXPECT_EQ(notes["two_soft_solids"], 8u);        // two layers twice, two meshes, two Renders
    EXPECT_EQ(notes["blend_constant_volume"], 7u);  // two layers twice, two meshes, a Render
    EXPECT_EQ(notes["flag"], 5u);                   // a Simulate twice, an Embed twice, a Render
    EXPECT_EQ(notes["breathing"], 4u);              // a layer twice, a mesh, a Render
}

TEST(OldFiles, APictureOfVersion1KeepsItsLook)
{
    const graph::Loaded bridge = graph::load_file(folder / "bridge.json", nodes::registry());
    const auto at = [&](const char* path) { return param(bridge.graph, "picture", path); };
    EXPECT_EQ(std::get<std::string>(at("look").is), "plain");
    EXPECT_EQ(std::get<std::string>(at("quality").is), "preview");
    EXPECT_EQ(std::get<std::string>(at("camera.hold").is), "box");
    EXPECT_TRUE(std::get<bool>(at("ground.grid").is));
    EXPECT_EQ(number(at("light.rim")), 0);
    EXPECT_EQ((std::get<std::array<double, 3>>(at("ground.colour").is)),
              (std::array<double, 3>{0.34, 0.34, 0.34}));
}

TEST(OldFiles, UnsetParametersKeepTheDefaultsOfTheirVersion)
{
    const graph::Loaded solids = graph::load_file(folder / "breathing.json", nodes::registry());
    const auto layer =
        std::find_if(solids.graph.nodes.begin(), solids.graph.nodes.end(),
                     [](const graph::Node& n) { return n.type->name == "ImplicitLayer"; });
    ASSERT_NE(layer, solids.graph.nodes.end());
    EXPECT_EQ(number(param(solids.graph, layer->name, "volume.derivative")), 0.2);  // it says so

    const graph::Loaded bridge = graph::load_file(folder / "bridge.json", nodes::registry());
    EXPECT_EQ(std::get<std::string>(param(bridge.graph, "samples", "mass").is), "density");
    EXPECT_EQ(number(param(bridge.graph, "samples", "thickness")), 0.1);
}

TEST(OldFiles, SampleOneHasATotalMassOfOneKilogramByDefault)
{
    const graph::Loaded loaded = load(R"(
        "plain": { "type": "Sample@1", "inputs": { "mesh": "ball.mesh" } },
        "dense": { "type": "Sample@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "mass": "density" } },
        "thick": { "type": "Sample@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "mass": "density", "thickness": 0.5 } },
        "now": { "type": "Sample@2", "inputs": { "mesh": "ball.mesh" } })");
    ASSERT_TRUE(loaded.ok());
    EXPECT_EQ(std::get<std::string>(param(loaded.graph, "plain", "mass").is), "total");
    EXPECT_EQ(number(param(loaded.graph, "plain", "total_mass")), 1);
    EXPECT_EQ(number(param(loaded.graph, "dense", "thickness")), 0.01);
    EXPECT_EQ(number(param(loaded.graph, "thick", "thickness")), 0.5);
    EXPECT_EQ(std::get<std::string>(param(loaded.graph, "now", "mass").is), "density");
    EXPECT_EQ(number(param(loaded.graph, "now", "thickness")), 0);
    EXPECT_EQ(loaded.problems.size(), 3u);
}

TEST(OldFiles, ImplicitLayerOneHasADerivativeOfZeroByDefault)
{
    const auto layer = [](const char* volume) {
        return std::string(R"("bones": { "type": "Skeletons@1" },
            "layer": { "type": "ImplicitLayer@1", "inputs": { "layer": "bones.layer" },
                       "params": { )") +
               volume + " } }";
    };
    const auto derivative = [&](const char* volume) {
        return number(param(load(layer(volume)).graph, "layer", "volume.derivative"));
    };
    EXPECT_EQ(derivative(R"("volume": { "proportional": 3 })"), 0);
    EXPECT_EQ(derivative(R"("volume": { "derivative": 0.5 })"), 0.5);
    EXPECT_EQ(derivative(R"("volume": { "derivative": 50 })"), 2);
}

TEST(OldFiles, ParticlesOfImplicitLayerTwoBlendWhereverTheyMeet)
{
    const auto separates = [](const char* type, const char* params) {
        const graph::Loaded loaded = load(fmt::format(R"("bones": {{ "type": "Skeletons@1" }},
                "layer": {{ "type": "{}", "inputs": {{ "layer": "bones.layer" }},
                            "params": {{ {} }} }})",
                                                      type, params));
        return std::get<bool>(param(loaded.graph, "layer", "substance.separates").is);
    };
    EXPECT_FALSE(separates("ImplicitLayer@1", R"("base": "particles")"));
    EXPECT_FALSE(separates("ImplicitLayer@2", R"("base": "particles")"));
    EXPECT_FALSE(
        separates("ImplicitLayer@2", R"("base": "particles", "substance": { "friction": 2 })"));
    EXPECT_TRUE(separates("ImplicitLayer@3", R"("base": "particles")"));
}

TEST(OldFiles, EmbedOneAndTwoKeepTheirTreatmentOfTears)
{
    const auto torn = [](const char* type, const char* params) {
        const graph::Loaded loaded =
            load(std::string(R"("cubes": { "type": "Voxelize@1", "inputs": { "mesh": "ball.mesh" },
                           "params": { "method": "solid" } },
                "sim": { "type": "Simulate@2", "inputs": { "cubes": "cubes.cubes" } },
                "shape": { "type": ")") +
                 type + R"(", "inputs": { "mesh": "ball.mesh", "cubes": "cubes.cubes",
                "state": "sim.state" })" +
                 params + " }");
        EXPECT_TRUE(loaded.ok()) << type << params;
        return std::get<std::string>(param(loaded.graph, "shape", "torn").is) + " " +
               std::get<std::string>(param(loaded.graph, "shape", "inside").is);
    };
    EXPECT_EQ(torn("Embed@1", ""), "hide material");
    EXPECT_EQ(torn("Embed@1", R"(, "params": { "hide_torn": true })"), "hide material");
    EXPECT_EQ(torn("Embed@1", R"(, "params": { "hide_torn": false })"), "stretch material");
    EXPECT_EQ(torn("Embed@2", ""), "cut open");
    EXPECT_EQ(torn("Embed@2", R"(, "params": { "torn": "cut" })"), "cut open");
    EXPECT_EQ(torn("Embed@2", R"(, "params": { "torn": "hide" })"), "hide material");
    EXPECT_EQ(torn("Embed@3", ""), "cut material");
}

TEST(OldFiles, LatticesOfSimulateOneAreCalibratedForBends)
{
    const graph::Loaded loaded = load(R"(
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "method": "solid" } },
        "plain": { "type": "Simulate@1", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "method": "lattice" } },
        "told": { "type": "Simulate@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                  "method": "lattice", "lattice": { "calibrate": "stretch", "half_width": 1 } } },
        "rated": { "type": "Simulate@1", "inputs": { "cubes": "cubes.cubes" }, "params": {
                   "method": "lattice", "lattice": { "stiffness": "rate" } } },
        "bricks": { "type": "Simulate@1", "inputs": { "cubes": "cubes.cubes" } },
        "now": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" },
                 "params": { "method": "lattice" } })");
    ASSERT_TRUE(loaded.ok());
    const auto of = [&](const char* node) {
        return std::get<std::string>(param(loaded.graph, node, "lattice.calibrate").is);
    };
    EXPECT_EQ(of("plain"), "bending");
    EXPECT_EQ(of("told"), "stretch");
    EXPECT_EQ(of("now"), "both");
    EXPECT_EQ(loaded.problems.size(), 8u);  // notes of the upgrades, two a node, and nothing else
}

TEST(OldFiles, SimulateTwoTakesOneStepAFrame)
{
    const graph::Loaded loaded = load(R"(
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "method": "solid" } },
        "plain": { "type": "Simulate@2", "inputs": { "cubes": "cubes.cubes" } },
        "block": { "type": "Simulate@2", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "step": { "tolerance": 0.01 } } },
        "told": { "type": "Simulate@2", "inputs": { "cubes": "cubes.cubes" },
                  "params": { "step": { "substeps": 0 } } },
        "now": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" } })");
    ASSERT_TRUE(loaded.ok());
    const auto of = [&](const char* node) {
        return std::get<std::int64_t>(param(loaded.graph, node, "step.substeps").is);
    };
    EXPECT_EQ(of("plain"), 1);
    EXPECT_EQ(of("block"), 1);
    EXPECT_EQ(number(param(loaded.graph, "block", "step.tolerance")), 0.01);
    EXPECT_EQ(of("told"), 0);
    EXPECT_EQ(of("now"), 0);
    EXPECT_EQ(loaded.problems.size(), 3u);
}

TEST(OldFiles, UpgradesAcceptMalformedNodes)
{
    for (const char* type : {"Sample@1", "ImplicitLayer@1", "Embed@1", "Embed@2"}) {
        for (const char* params : {"3", "[]", "null", R"({ "mass": 7, "volume": 3 })",
                                   R"({ "mass": "=frame", "volume": { "derivative": "no" } })"}) {
            const graph::Loaded loaded = load(std::string(R"("strange": { "type": ")") + type +
                                              R"(", "params": )" + params + " }");
            EXPECT_FALSE(loaded.ok()) << type << " " << params;
        }
    }
}

}  // namespace
