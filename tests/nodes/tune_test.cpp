// `aspic tune` on beams whose sag is known.

#include "nodes/body_figures.hpp"
#include "runtime/commands/command_line.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>

namespace tuned_beams {
namespace {

constexpr double length = 0.8, side = 0.1, young = 1e7, density = 1000;

// Clamped at one end, in equilibrium under its weight; its square section turned about its axis.
std::string beam(double degrees)
{
    return fmt::format(
        R"({{ "aspic": 1, "frames": {{ "last": 1 }}, "nodes": {{
    "box": {{ "type": "Primitive@1", "params": {{ "shape": "beam", "centre": [0.4, 0, 0],
        "beam": {{ "length": {}, "height": {}, "width": {}, "divisions": 8 }} }} }},
    "turned": {{ "type": "Transform@1", "inputs": {{ "mesh": "box.mesh" }},
        "params": {{ "rotate_degrees": [{}, 0, 0] }} }},
    "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "turned.mesh" }}, "params": {{
        "method": "solid", "size": 0.1,
        "matter": {{ "density": {}, "young": {}, "poisson": 0 }} }} }},
    "wall": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
        "params": {{ "where": "ends", "ends": {{ "axis": "x", "end": "low", "layers": 0 }} }} }},
    "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes", "pins": ["wall.pins"] }},
        "params": {{ "initial_shape": "equilibrium" }} }},
    "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "turned.mesh", "cubes": "cubes.cubes",
        "state": "sim.state" }} }},
    "sag": {{ "type": "Measure@1", "inputs": {{ "mesh": "shape.mesh", "rest": "turned.mesh" }},
        "params": {{ "what": "displacement_at", "point": [0.8, 0, 0], "direction": [0, -1, 0] }} }}
    }} }})",
        length, side, side, degrees, density, young);
}

// q L^4 / 8 E I and the shear's q L^2 / 2 k G A with k = 5/6. A square bends alike all ways.
double expected_sag()
{
    const double q = density * 9.81 * side * side, bending = young * std::pow(side, 4) / 12;
    return q * std::pow(length, 4) / (8 * bending) +
           q * length * length / (2 * 5.0 / 6 * young / 2 * side * side);
}

struct Said {
    int exit = 0;
    std::vector<nlohmann::json> lines;
};

Said tuned(double degrees, const std::string& error)
{
    const files::Folder folder;
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    console.count_cubes = nodes::count_cubes;
    Said said;
    said.exit = runtime::run_command_line(
        {"tune", folder.write("beam.json", beam(degrees)).string(), "--error", error, "--json",
         "--no-disk-cache", "--cubes", "20000"},
        nodes::registry(), console);
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) {
        said.lines.push_back(nlohmann::json::parse(line));
    }
    EXPECT_FALSE(said.lines.empty()) << err.str();
    return said;
}

// What the recommended size was measured to sag.
double recommended_sag(const Said& said)
{
    const auto& size = said.lines.back()["recommended"]["cubes.size"];
    for (const auto& line : said.lines) {
        if (line.contains("setting") && line["setting"]["cubes.size"] == size) {
            return line["values"]["sag.value"].get<double>();
        }
    }
    return 0;
}

TEST(Tune, ABeamAlongTheGridNeedsOneCubeAcross)
{
    const Said said = tuned(0, "5%");
    EXPECT_EQ(said.exit, runtime::exit_ok);
    EXPECT_EQ(said.lines.back()["recommended"]["cubes.size"], 0.1);
    EXPECT_NEAR(recommended_sag(said), expected_sag(), 0.05 * expected_sag());
    EXPECT_EQ(said.lines[0]["cubes"], 4);  // of 0.2 m, filled to a quarter: far too stiff
    EXPECT_GT(said.lines[0]["error"].get<double>(), 0.5);
}

TEST(Tune, ATurnedBeamNeedsMoreCubesAndGetsThem)
{
    const Said said = tuned(45, "15%");
    EXPECT_EQ(said.exit, runtime::exit_ok);
    EXPECT_LT(said.lines.back()["recommended"]["cubes.size"].get<double>(), 0.1);
    EXPECT_NEAR(recommended_sag(said), expected_sag(), 0.15 * expected_sag());
}

// Of a beam that bends under its weight, from its first frame on.
TEST(Tune, TriesErrorsOfStepsWhereTheyChooseTheirNumber)
{
    std::string graph = beam(0);
    const auto replace = [&](const std::string& from, const std::string& to) {
        ASSERT_NE(graph.find(from), std::string::npos) << from;
        graph.replace(graph.find(from), from.size(), to);
    };
    replace(R"("initial_shape": "equilibrium")", R"("step": { "error": 0.04 })");
    const files::Folder folder;
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    const auto run = [&](const std::string& text) {
        out.str("");
        runtime::run_command_line({"tune", folder.write("beam.json", text).string(), "--size",
                                   "cubes.size", "--error", "50%", "--json", "--no-disk-cache",
                                   "--cubes", "2000"},
                                  nodes::registry(), console);
        return out.str();
    };
    EXPECT_NE(run(graph).find(R"("sim.step.error":0.02)"), std::string::npos)
        << out.str() << err.str();
    replace(R"("error": 0.04)", R"("error": 0.04, "integrator": "sdirk2")");
    EXPECT_EQ(run(graph).find("sim.step.error"), std::string::npos) << "it has no effect";
}

// The mass is the same by cubes of all sizes, of which those that are larger than the beam is thick
// warn.
TEST(Tune, RecommendsNoSettingThatWarnsOfMoreThanTheFinest)
{
    std::string graph = beam(0);
    const auto sag = graph.find(R"("sag": {)");
    graph.resize(sag);
    graph += R"("sag": { "type": "Measure@1", "inputs": { "cubes": "cubes.cubes" },
        "params": { "what": "mass" } } } })";
    const files::Folder folder;
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    console.count_cubes = nodes::count_cubes;
    runtime::run_command_line({"tune", folder.write("beam.json", graph).string(), "--error", "5%",
                               "--json", "--no-disk-cache", "--cubes", "20000"},
                              nodes::registry(), console);
    std::istringstream text(out.str());
    std::vector<nlohmann::json> lines;
    for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
    ASSERT_GE(lines.size(), 3u) << err.str();
    const auto& recommended = lines.back()["recommended"];
    std::size_t least = 1000, most = 0, taken = 1000;
    for (const auto& line : lines) {
        if (!line.contains("setting")) continue;
        const std::size_t warnings = line["warnings"].size();
        least = std::min(least, warnings), most = std::max(most, warnings);
        if (line["setting"]["cubes.size"] == recommended["cubes.size"]) taken = warnings;
    }
    EXPECT_GT(most, least);
    EXPECT_EQ(taken, least) << out.str();
}

TEST(Tune, NamesCalibratedCubesWhereFilledOnesAreMany)
{
    const auto said = [](double degrees, const std::string& error) {
        const files::Folder folder;
        std::ostringstream out, err;
        runtime::Console console{out, err, false, {}, {}, "test"};
        console.count_cubes = nodes::count_cubes;
        runtime::run_command_line({"tune", folder.write("beam.json", beam(degrees)).string(),
                                   "--error", error, "--no-disk-cache", "--cubes", "20000"},
                                  nodes::registry(), console);
        return out.str();
    };
    EXPECT_NE(said(45, "3%").find("--set cubes.stiffness=calibrated"), std::string::npos);
    EXPECT_EQ(said(0, "5%").find("calibrated"), std::string::npos);
}

TEST(Tune, CubesThatChooseTheirSizeAreNotTuned)
{
    std::string graph = beam(0);
    const std::string by_hand = "\"size\": 0.1";
    graph.replace(graph.find(by_hand), by_hand.size(), "\"size\": \"good\"");
    const files::Folder folder;
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    EXPECT_NE(runtime::run_command_line(
                  {"tune", folder.write("beam.json", graph).string(), "--no-disk-cache"},
                  nodes::registry(), console),
              runtime::exit_ok);
    EXPECT_NE(err.str().find("set quality = by_size to tune it"), std::string::npos) << err.str();
}

}  // namespace
}  // namespace tuned_beams
