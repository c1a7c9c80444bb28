// What pictures tell beside what they show: comparisons, burn-in, ghosts, onion skins.

#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using fixtures::Scene;

// A ball at two places, in two small pictures of one camera, which `compare` compares.
std::string two_balls(const std::string& compare, const std::string& width_of_b = "64")
{
    const std::string same = R"("height": 48, "look": "plain", "quality": "draft", "camera": {
        "kind": "look_at", "eye": [0, 0, 9], "target": [0, 0, 0] })";
    return R"(
        "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
        "moved": { "type": "Transform@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "translate": [0.5, 0, 0] } },
        "one": { "type": "Render@2", "inputs": { "mesh": "ball.mesh" },
                 "params": { "width": 64, )" +
           same + R"( } },
        "two": { "type": "Render@2", "inputs": { "mesh": "moved.mesh" },
                 "params": { "width": )" +
           width_of_b + ", " + same + R"( } },
        "c": { "type": "Compare@1", "inputs": { "a": "one.image", "b": "two.image" },
               "params": { "label_a": "", "label_b": "", )" +
           compare + R"( } },
        "sheet": { "type": "ContactSheet@1", "inputs": { "image": "c.image" },
                   "params": { "count": 2, "columns": 2, "width": 400 } })";
}

TEST(CompareNode, ShowsTwoPicturesOfAGraph)
{
    const files::Folder folder;
    Scene scene(two_balls(R"("mode": "wipe", "wipe": { "keys": [[1, 0], [3, 1]] })"), folder.path,
                3);
    const auto one = scene.at<::render::Image>("one"), two = scene.at<::render::Image>("two");
    EXPECT_EQ(scene.at<::render::Image>("c", 1)->rgba, two->rgba);
    EXPECT_EQ(scene.at<::render::Image>("c", 3)->rgba, one->rgba);
    const auto half = scene.at<::render::Image>("c", 2);
    EXPECT_NE(half->rgba, one->rgba);
    EXPECT_NE(half->rgba, two->rgba);
    // Its picture goes where any other goes.
    EXPECT_EQ(scene.at<::render::Image>("sheet")->width, 400);

    Scene beside(two_balls(R"("mode": "side_by_side")"), folder.path);
    EXPECT_EQ(beside.at<::render::Image>("c")->width, 130);
}

TEST(CompareNode, SaysBothSizesWhereTheyDiffer)
{
    const files::Folder folder;
    Scene scene(two_balls(R"("mode": "difference")", "96"), folder.path);
    const std::string why = scene.failure_at<::render::Image>("c");
    EXPECT_NE(why.find("a is 64 x 48 and b is 96 x 48"), std::string::npos) << why;
}

// A box that is at x = f m in frame f of ten, as an Onion holds it: at which x, in its order.
std::vector<int> places_of(fixtures::NodeRun& onion)
{
    const geometry::TriMesh box = geometry::box({1, 1, 1}, {1, 1, 1});
    onion.gathered = onion.type.gather_frames(onion.params, onion.range);
    onion.inputs["mesh"].clear();
    for (const int frame : onion.gathered) {
        geometry::TriMesh moved = box;
        for (auto& p : moved.positions) p.x() += float(frame);
        onion.inputs["mesh"].push_back(graph::Value::of(std::move(moved)));
    }
    const graph::Value value = onion.run();
    std::vector<int> places;
    const auto& positions = value.as<geometry::TriMesh>()->positions;
    for (std::size_t v = 0; v < positions.size(); v += box.positions.size()) {
        places.push_back(int(std::lround(positions[v].x() - box.positions[0].x())));
    }
    return places;
}

TEST(OnionNode, HoldsTheChosenFramesTheLatestFirst)
{
    fixtures::NodeRun onion("Onion");
    onion.param("choose").is = std::string("spread");
    onion.param("count").is = std::int64_t{4};
    EXPECT_EQ(places_of(onion), (std::vector<int>{10, 7, 4, 1}));
    onion.param("choose").is = std::string("every");
    onion.param("every").is = std::int64_t{4};
    EXPECT_EQ(places_of(onion), (std::vector<int>{10, 6, 2}));
    onion.param("choose").is = std::string("list");
    onion.param("frames").is = std::string("8, 3, 5, 3");
    EXPECT_EQ(places_of(onion), (std::vector<int>{8, 5, 3}));
    EXPECT_TRUE(onion.warnings.empty());
    onion.param("frames").is = std::string("2 14");
    EXPECT_EQ(places_of(onion), (std::vector<int>{2}));
    ASSERT_EQ(onion.warnings.size(), 1u);
    EXPECT_EQ(onion.warnings[0], "frame 14 of `frames` is left out: the graph has frames 1 to 10");
}

TEST(OnionNode, RefusesFramesThatAreNoNumbers)
{
    const auto loaded = graph::load_text(R"({ "aspic": 1, "frames": { "last": 3 }, "nodes": {
        "box": { "type": "Primitive@1" },
        "o": { "type": "Onion@1", "inputs": { "mesh": "box.mesh" },
               "params": { "choose": "list", "frames": "1, two" } } } })",
                                         "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_NE(loaded.problems[0].message.find("whole numbers parted by commas, found \"1, two\""),
              std::string::npos)
        << loaded.problems[0].message;
}

}  // namespace
