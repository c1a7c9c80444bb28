// The seconds that pictures show where a simulation takes another time a frame than the video.

#include "graph/document/scene_pace.hpp"
#include "nodes/render_burn_in.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using fixtures::Scene;

// A cube without gravity, drawn with its seconds, beside a second one with parameters of its own.
std::string two_cubes(const std::string& sim, const std::string& other, const std::string& burn_in)
{
    const auto simulate = [](const std::string& params) {
        return fmt::format(R"({{ "type": "Simulate@3", "inputs": {{ "cubes": "body.cubes" }},
            "params": {{ "gravity": [0, 0, 0] {} }} }})",
                           params);
    };
    return fmt::format(R"(
    "box": {{ "type": "Primitive@1" }},
    "body": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "box.mesh" }},
               "params": {{ "method": "solid", "size": 1 }} }},
    "sim": {}, "other": {},
    "shape": {{ "type": "Embed@3",
                "inputs": {{ "mesh": "box.mesh", "cubes": "body.cubes", "state": "sim.state" }} }},
    "second": {{ "type": "Embed@3",
                 "inputs": {{ "mesh": "box.mesh", "cubes": "body.cubes", "state": "other.state" }} }},
    "one": {{ "type": "Render@2", "inputs": {{ "mesh": "shape.mesh", "rest": "box.mesh" }},
              "params": {{ "width": 160, "height": 60, "quality": "draft", "look": "plain",
                           "burn_in": {{ "seconds": true {} }} }} }},
    "both": {{ "type": "Render@2",
               "inputs": {{ "mesh": ["shape.mesh", "second.mesh"], "rest": "box.mesh" }} }},
    "sheet": {{ "type": "ContactSheet@1", "inputs": {{ "image": "one.image" }},
                "params": {{ "count": 2, "columns": 2, "width": 400 }} }})",
                       simulate(sim), simulate(other), burn_in);
}

double pace_of(const std::string& node, const std::string& nodes)
{
    const auto loaded = graph::load_text(
        R"({ "aspic": 1, "frames": { "last": 3, "fps": 24 }, "nodes": {)" + nodes + "} }",
        "scene.json", nodes::registry());
    for (std::uint32_t n = 0; n < loaded.graph.nodes.size(); ++n) {
        if (loaded.graph.nodes[n].name == node) return graph::scene_pace(loaded.graph, n);
    }
    ADD_FAILURE() << "no node " << node;
    return -1;
}

TEST(SceneTime, FollowsFromTheSimulationsThatANodeDependsOn)
{
    constexpr const char* slow = R"(, "dt": "=1/96")";
    EXPECT_DOUBLE_EQ(pace_of("sheet", two_cubes(slow, "", "")), 1.0 / 96);
    EXPECT_DOUBLE_EQ(pace_of("one", two_cubes("", slow, "")), 1.0 / 24);
    EXPECT_DOUBLE_EQ(pace_of("both", two_cubes(slow, slow, "")), 1.0 / 96);
    EXPECT_EQ(pace_of("both", two_cubes(slow, "", "")), 0) << "they disagree";
    EXPECT_EQ(pace_of("body", two_cubes(slow, slow, "")), 0) << "depends on none";
    // What Render states counts for its sheet; what moves for nobody.
    EXPECT_DOUBLE_EQ(pace_of("sheet", two_cubes(slow, "", R"(, "slow_motion": 10)")), 1.0 / 240);
    const char* const moves = R"(, "dt": { "keys": [[1, 0.01], [3, 0.02]] })";
    EXPECT_EQ(pace_of("sheet", two_cubes(moves, "", "")), 0);
}

TEST(SceneTime, OfPicturesIsThatOfTheScene)
{
    const files::Folder folder;
    const auto picture = [&](const char* node, const char* sim, const char* burn_in) {
        Scene scene(two_cubes(sim, "", burn_in), folder.path, 3);
        return scene.at<::render::Image>(node, 3)->rgba;
    };
    constexpr const char* slow = R"(, "dt": "=1/96")";
    // A quarter of the video's time, and what says so.
    EXPECT_EQ(picture("one", slow, ""), picture("one", "", R"(, "slow_motion": 4)"));
    EXPECT_NE(picture("one", slow, ""), picture("one", "", ""));
    EXPECT_EQ(picture("one", slow, R"(, "slow_motion": 1)"), picture("one", "", "")) << "stated";
    EXPECT_EQ(picture("sheet", slow, ""), picture("sheet", "", R"(, "slow_motion": 4)"));
}

TEST(SceneTime, IsBelowThePicturesOfAContactSheet)
{
    const files::Folder folder;
    fixtures::NodeRun sheet("ContactSheet");
    sheet.output_folder = folder.path;
    sheet.param("count").is = std::int64_t{2};
    const ::render::Image grey{64, 48, std::vector<std::uint8_t>(64 * 48 * 4, 200)};
    sheet.inputs["image"] = {graph::Value::of(::render::Image(grey)),
                             graph::Value::of(::render::Image(grey))};
    const auto sheet_at = [&](double pace) {
        sheet.pace = pace;
        return sheet.run().as<::render::Image>()->rgba;
    };
    EXPECT_EQ(sheet_at(0), sheet_at(1.0 / 24));
    EXPECT_NE(sheet_at(0), sheet_at(1.0 / 96));
}

TEST(SceneTime, HasMoreDecimalsInSlowMotion)
{
    using nodes::seconds_text;
    EXPECT_EQ(seconds_text(0.125, 1), "0.13 s");
    EXPECT_EQ(seconds_text(0.375, 1), "0.38 s");
    EXPECT_EQ(seconds_text(1.005, 1), "1.01 s");
    EXPECT_EQ(seconds_text(1 / 24.0, 1), "0.04 s");
    EXPECT_EQ(seconds_text(-0.125, 1), "-0.13 s");
    EXPECT_EQ(seconds_text(0.125, 4), "0.031 s");
    EXPECT_EQ(seconds_text(0.125, 0.5), "0.25 s");
    using nodes::render::burn_in_text;
    EXPECT_EQ(burn_in_text({"", false, true, 0, ""}, {}, 7, 0.25, "", 4),
              "0.063 s   slow motion 4x");
    EXPECT_EQ(burn_in_text({"", true, false, 0, ""}, {}, 7, 0.25, "", 4), "frame 7");
    EXPECT_EQ(burn_in_text({"", false, true, 1, ""}, {}, 7, 0.25, "", 4), "0.25 s");
}

}  // namespace
