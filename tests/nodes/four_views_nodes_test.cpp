// Four views beside a camera that stands where it was put.

#include "tests/nodes/scene.hpp"

namespace {

// A block, seen in four views of which the parallel ones leave `margin` free.
std::shared_ptr<const render::Image> picture(const std::string& margin)
{
    fixtures::Scene scene(R"(
        "block": { "type": "Primitive@1", "params": { "shape": "box" } },
        "picture": { "type": "Render@2", "inputs": { "mesh": "block" },
            "params": { "width": 130, "height": 130, "quality": "draft", "look": "plain",
                "ground": { "kind": "none" },
                "camera": { "kind": "look_at", "eye": [3, 2, 4], "views": "four", "hold": "box",
                            "margin": )" +
                          margin + " } } }");
    return scene.at<render::Image>("picture");
}

// The front view is below at the left; the camera's own, above at the right, has no margin.
TEST(FourViewsNode, TheParallelViewsHaveAMarginWhereTheCameraHasNone)
{
    const auto narrow = picture("0.05"), wide = picture("0.4");
    ASSERT_EQ(narrow->rgba.size(), wide->rgba.size());
    int camera = 0, front = 0;
    for (int y = 0; y < 130; ++y) {
        for (int x = 0; x < 130; ++x) {
            const auto at = std::ptrdiff_t(4 * (130 * y + x));
            const bool same = std::equal(narrow->rgba.begin() + at, narrow->rgba.begin() + at + 4,
                                         wide->rgba.begin() + at);
            camera += !same && x > 66 && y < 64 ? 1 : 0;
            front += !same && x < 64 && y > 66 ? 1 : 0;
        }
    }
    EXPECT_EQ(camera, 0);
    // A square face of 90 % of 64 pixels has 3,300 of them, one of 20 % has 160.
    EXPECT_GT(front, 1000);
}

}  // namespace
