// What pictures tell beside what they show: comparisons, burn-in, ghosts, onion skins.

#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

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

}  // namespace
