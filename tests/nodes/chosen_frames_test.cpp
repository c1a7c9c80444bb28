// Contact sheets that choose the frames where something happens.

#include "geometry/mesh/primitive.hpp"
#include "render/choose_frames.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using fixtures::NodeRun;
using Places = std::vector<std::size_t>;

// A white square that goes to the right by 2 pixels in each frame from `begin` to `end`.
render::Image picture(int frame, int begin, int end)
{
    render::Image image{96, 24, std::vector<std::uint8_t>(96 * 24 * 4, 0)};
    const int left = 2 * (std::clamp(frame, begin, end) - begin);
    for (int y = 8; y < 16; ++y) {
        for (int x = left; x < left + 8; ++x) {
            for (int c = 0; c < 4; ++c) image.rgba[std::size_t(4 * (96 * y + x) + c)] = 255;
        }
    }
    return image;
}

Places chosen_by_change(int frames, int begin, int end, std::size_t count)
{
    std::vector<render::Image> images;
    for (int f = 0; f < frames; ++f) images.push_back(picture(f, begin, end));
    std::vector<const render::Image*> pictures;
    for (const auto& image : images) pictures.push_back(&image);
    return render::spread_by_change(render::changes_of(pictures), count);
}

TEST(ChosenFrames, LieWhereThePictureChanges)
{
    // It moves from 40 to 50 alone: five equal parts of that way end at 42, 44, 46 and 48.
    EXPECT_EQ(chosen_by_change(100, 40, 50, 6), (Places{0, 42, 44, 46, 48, 99}));
    // More than there are: all that differ.
    EXPECT_EQ(chosen_by_change(100, 40, 43, 12), (Places{0, 41, 42, 99}));
    EXPECT_EQ(chosen_by_change(100, 40, 41, 12), (Places{0, 99}));
    // Nothing moves, all the time, or there is hardly a frame.
    EXPECT_EQ(chosen_by_change(9, 20, 30, 3), (Places{0, 4, 8}));
    EXPECT_EQ(chosen_by_change(9, 0, 8, 5), (Places{0, 2, 4, 6, 8}));
    EXPECT_EQ(chosen_by_change(9, 0, 8, 1), Places{0});
    EXPECT_EQ(chosen_by_change(1, 0, 8, 5), Places{0});
    EXPECT_EQ(chosen_by_change(2, 0, 8, 5), (Places{0, 1}));
    EXPECT_TRUE(render::spread_by_change({}, 5).empty());
}

TEST(ChosenFrames, PicturesOfDifferentSizesAreRefused)
{
    const render::Image a = picture(0, 0, 1), b{2, 2, std::vector<std::uint8_t>(16)};
    const std::vector<const render::Image*> both{&a, &b};
    EXPECT_THROW(render::changes_of(both), std::invalid_argument);
}

// A swing that dies away, with a tremor upon it: its greatest turns, in order.
TEST(ChosenFrames, LieWhereAValueTurns)
{
    std::vector<double> values;
    for (int i = 0; i <= 80; ++i) {
        values.push_back(std::exp(-0.02 * i) * std::sin(0.157 * i) + (i % 2 ? 1e-3 : 0));
    }
    // Turns of the swing: where tan(0.157 i) = 0.157 / 0.02, 1.444 / 0.157 = 9.2 and then each half
    // period of 20 further.
    const auto few = render::extremes_of(values, 5);
    ASSERT_EQ(few.size(), 5u);
    for (std::size_t k = 1; k < 4; ++k)
        EXPECT_NEAR(double(few[k]), 9.2 + 20.0 * double(k - 1), 1.5);
    EXPECT_EQ(few.front(), 0u);
    EXPECT_EQ(few.back(), 80u);

    EXPECT_EQ(render::extremes_of(std::vector<double>{0, 1, 0, 5, 0, 1, 0}, 3), (Places{0, 3, 6}));
    EXPECT_EQ(render::extremes_of(std::vector<double>{0, 2, 2, 2, 0}, 3), (Places{0, 1, 4}));
    // It only grows: parted evenly. It is constant: spread. It is nothing: as before.
    EXPECT_EQ(render::extremes_of(std::vector<double>{0, 1, 2, 3, 4}, 3), (Places{0, 2, 4}));
    EXPECT_EQ(render::extremes_of(std::vector<double>(5, 7.0), 3), (Places{0, 2, 4}));
    EXPECT_EQ(render::extremes_of(std::vector<double>{NAN, 1, NAN, 5, 0}, 3), (Places{0, 3, 4}));
    EXPECT_EQ(render::extremes_of(std::vector<double>{NAN, 100, 100, 101, 99, 100}, 4),
              (Places{0, 3, 4, 5}));
    EXPECT_EQ(render::extremes_of(std::vector<double>{3}, 3), Places{0});
}

TEST(ContactSheet, ShowsWhereSomethingHappens)
{
    const files::Folder folder;
    NodeRun sheet("ContactSheet");
    sheet.output_folder = folder.path;
    sheet.range = {1, 60, 24};
    sheet.param("count").is = std::int64_t{4};
    sheet.param("choose").is = std::string("change");
    const auto asked = sheet.type.gather_frames(sheet.params, sheet.range);
    EXPECT_EQ(asked.size(), 60u);
    for (const int f : asked) sheet.inputs["image"].push_back(graph::Value::of(picture(f, 30, 36)));
    const auto chosen = sheet.run().as<render::Image>()->rgba;

    NodeRun alone("ContactSheet");  // of these frames and no others
    alone.output_folder = folder.path;
    alone.range = sheet.range;
    alone.gathered = {1, 32, 34, 60};
    for (const int f : alone.gathered) {
        alone.inputs["image"].push_back(graph::Value::of(picture(f, 30, 36)));
    }
    EXPECT_EQ(chosen, alone.run().as<render::Image>()->rgba);

    sheet.range.last = 4000;  // what a sheet may hold in memory
    EXPECT_EQ(sheet.type.gather_frames(sheet.params, sheet.range).size(), 500u);
}

TEST(ContactSheet, FollowsAValueOfTheGraph)
{
    const files::Folder folder;
    const std::string nodes = R"(
        "box": { "type": "Primitive@1" },
        "moved": { "type": "Transform@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "translate": { "keys": [[1, [0, 0, 0]], [7, [0, 3, 0]],
                                                       [20, [0, 0, 0]]] } } },
        "up": { "type": "Measure@1", "inputs": { "mesh": "moved.mesh" },
                "params": { "what": "highest", "direction": [0, 1, 0] } },
        "p": { "type": "Render@2", "inputs": { "mesh": "moved.mesh" },
               "params": { "width": 64, "height": 48, "quality": "draft" } },
        "sheet": { "type": "ContactSheet@1", "inputs": { "image": "p.image", "value": "up.value" },
                   "params": { "choose": "value", "count": 3, "columns": 3, "width": 400 } })";
    fixtures::Scene scene(nodes, folder.path, 20);
    EXPECT_EQ(scene.at<render::Image>("sheet")->width, 400);

    const auto loaded = graph::load_text(R"({ "aspic": 1, "nodes": {
        "box": { "type": "Primitive@1" },
        "p": { "type": "Render@2", "inputs": { "mesh": "box.mesh" } },
        "s": { "type": "ContactSheet@1", "inputs": { "image": "p.image" },
               "params": { "choose": "value" } } } })",
                                         "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_NE(loaded.problems[0].message.find("link a Measure"), std::string::npos);
}

}  // namespace
