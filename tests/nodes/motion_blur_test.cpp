// Motion blur: how far a streak reaches, that no light is lost, and what stays as it is.

#include "geometry/base/srgb.hpp"
#include "geometry/mesh/primitive.hpp"
#include "render/exr.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using fixtures::NodeRun;
using render::Image;

constexpr float radius = 0.4f;
constexpr double per_metre = 192 / 6.551;  // pixels: at 9 m and 40 degrees, 2 * 9 tan 20 m are seen

geometry::TriMesh ball(float x, int finer = 3)
{
    geometry::TriMesh mesh = geometry::icosphere(radius, finer);
    for (auto& p : mesh.positions) p.x() += x;
    return mesh;
}

// A dark ball on white, from the front, that came from `before` to `now` (m) in a frame.
NodeRun flight(float before, float now)
{
    NodeRun render("Render");
    render.param("width").is = std::int64_t{192};
    render.param("height").is = std::int64_t{192};
    render.param("look").is = std::string("plain");
    render.param("quality").is = std::string("draft");
    render.param("ground.kind").is = std::string("none");
    render.param("backdrop.top").is = std::array<double, 3>{0.7, 0.7, 0.7};
    render.param("backdrop.horizon").is = std::array<double, 3>{0.7, 0.7, 0.7};
    render.param("colour.by").is = std::string("constant");
    render.param("colour.constant").is = std::array<double, 3>{0, 0, 0};
    render.param("light.shadow").is = std::string("off");
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.eye").is = std::array<double, 3>{0, 0, 9};
    render.param("camera.target").is = std::array<double, 3>{0, 0, 0};
    render.param("camera.field_of_view").is = 40.0;
    render.inputs["mesh"] = {graph::Value::of(ball(now))};
    render.inputs["before"] = {graph::Value::of(ball(before))};
    return render;
}

double light_of(std::uint8_t byte)
{
    return geometry::linear_from_srgb(geometry::Vec3f::Constant(float(byte) / 255))[0];
}

// What the picture lacks of an empty one, in pixels of full darkness.
double darkness(const Image& image)
{
    const double empty = light_of(image.rgba[1]);
    double sum = 0;
    for (std::size_t i = 1; i < image.rgba.size(); i += 4) {
        sum += 1 - light_of(image.rgba[i]) / empty;
    }
    return sum;
}

// Pixels of the middle row that are not empty: by more than the one step that dither makes.
int streak(const Image& image)
{
    const std::size_t row = 4 * std::size_t(image.width) * std::size_t(image.height / 2);
    int count = 0;
    for (std::size_t x = 0; x < std::size_t(image.width); ++x) {
        count += std::abs(image.rgba[row + 4 * x + 1] - image.rgba[1]) > 1;
    }
    return count;
}

// A ball that flies 3 m in a frame leaves, with the shutter open for a share s of it, a streak as
// long as itself and 3 s (1 - 1/n) m more: the first and the last of n pictures are taken half an
// n-th after the shutter opens and before it closes. Two pixels more or less: of either end.
TEST(MotionBlur, AStreakIsAsLongAsSpeedTimesShutter)
{
    NodeRun render = flight(-1.5f, 1.5f);
    for (const double shutter : {0.25, 0.5, 1.0}) {
        render.param("motion_blur.shutter").is = shutter;
        render.param("motion_blur.samples").is = std::int64_t{32};
        const auto image = render.run().as<Image>();
        const double metres = 2 * double(radius) + 3 * shutter * (1 - 1.0 / 32);
        EXPECT_NEAR(streak(*image), metres * per_metre, 2) << shutter;
        // It ends where the ball is now.
        std::size_t last = 0;
        for (std::size_t x = 0; x < 192; ++x) {
            if (std::abs(image->rgba[4 * (192 * 96 + x) + 1] - image->rgba[1]) > 1) last = x;
        }
        const double ends = 1.5 + double(radius) - 3 * shutter / 64;
        EXPECT_NEAR(double(last), 96 + ends * per_metre, 2) << shutter;
    }
}

// The mean of light takes as much from the backdrop as one ball does. 3 %: towards the sides of the
// picture a ball is seen a little larger, and the ball itself sends out some light.
TEST(MotionBlur, LosesNoLight)
{
    NodeRun render = flight(-0.75f, 0.75f);
    const double still = darkness(*render.run().as<Image>());
    EXPECT_GT(still, 100);
    const auto corner = render.run().as<Image>()->rgba[1];
    render.param("motion_blur.shutter").is = 1.0;
    for (const char* quality : {"draft", "preview", "standard", "final"}) {
        render.param("quality").is = std::string(quality);
        EXPECT_NEAR(darkness(*render.run().as<Image>()), still, 0.03 * still) << quality;
        EXPECT_EQ(render.run().as<Image>()->rgba[1], corner) << quality;
    }
    // Nor does light for compositing: what covers pixels is as much as before.
    render.param("quality").is = std::string("draft");
    render.param("linear").is = std::string("cut_out");
    const auto covered = [&] {
        const auto image = render.run().as<Image>();
        double sum = 0;
        for (std::size_t i = 3; i < image->light.size(); i += 4) {
            sum += double(render::of_half(image->light[i]));
        }
        return sum;
    };
    const double blurred = covered();
    // And its depths are the nearest.
    const auto image = render.run().as<Image>();
    EXPECT_NEAR(*std::min_element(image->depth.begin(), image->depth.end()), 9 - radius, 0.02);
    render.param("motion_blur.shutter").is = 0.0;
    EXPECT_NEAR(blurred, covered(), 0.03 * blurred);
}

TEST(MotionBlur, WhatStandsStillOrIsNotAskedForKeepsItsBytes)
{
    NodeRun render = flight(0, 0);
    const auto plain = [&] {
        NodeRun without = flight(0, 0);
        without.inputs["before"].clear();
        return without.run().as<Image>()->rgba;
    }();
    render.param("motion_blur.shutter").is = 0.5;
    EXPECT_EQ(render.run().as<Image>()->rgba, plain);
    render.inputs["before"] = {graph::Value::of(ball(-1))};
    EXPECT_NE(render.run().as<Image>()->rgba, plain);
    render.param("motion_blur.shutter").is = 0.0;
    EXPECT_EQ(render.run().as<Image>()->rgba, plain);
    // Other faces: there is no way from these to those.
    render.param("motion_blur.shutter").is = 0.5;
    render.inputs["before"] = {graph::Value::of(ball(-1, 2))};
    EXPECT_EQ(render.run().as<Image>()->rgba, plain);
}

TEST(MotionBlur, ACloudLeavesStreaksToo)
{
    NodeRun render = flight(0, 0);
    geometry::TriMesh now, before;
    now.positions = {{1, 0, 0}};
    before.positions = {{-1, 0, 0}};
    render.inputs["mesh"] = {graph::Value::of(now)};
    render.inputs["before"] = {graph::Value::of(before)};
    render.param("show.point_size").is = 0.4;
    EXPECT_NEAR(streak(*render.run().as<Image>()), 0.4 * per_metre, 2);
    render.param("motion_blur.shutter").is = 1.0;
    render.param("motion_blur.samples").is = std::int64_t{32};
    EXPECT_NEAR(streak(*render.run().as<Image>()), (0.4 + 2 * 31 / 32.0) * per_metre, 2);
}

TEST(MotionBlur, AGraphRemembersTheFrameBefore)
{
    const files::Folder folder;
    const std::string moved = R"(
        "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
        "moved": { "type": "Transform@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "translate": { "keys": [[1, [0, 0, 0]], [11, [10, 0, 0]]] } } },
        "b": { "type": "Before@1", "inputs": { "mesh": "moved.mesh" } },
        "was": { "type": "Transform@1", "inputs": { "mesh": "b.before" } },
        "p": { "type": "Render@2", "inputs": { "mesh": "b.mesh", "before": "b.before" },
               "params": { "width": 64, "height": 48, "motion_blur": { "shutter": 0.5 } } })";
    fixtures::Scene scene(moved, folder.path, 11);
    using geometry::TriMesh;
    const auto x = [&](const char* node, int frame) {
        return scene.at<TriMesh>(node, frame)->positions[0].x();
    };
    EXPECT_EQ(x("was", 1), x("moved", 1));
    EXPECT_EQ(x("was", 7), x("moved", 6));
    EXPECT_GT(x("moved", 7), x("moved", 6));
    EXPECT_EQ(scene.at<Image>("p", 7)->width, 64);
}

TEST(MotionBlur, SaysWhatItNeeds)
{
    const auto loaded = graph::load_text(R"({ "aspic": 1, "nodes": {
        "box": { "type": "Primitive@1" },
        "p": { "type": "Render@2", "inputs": { "mesh": "box.mesh" },
               "params": { "motion_blur": { "shutter": 0.5 } } } } })",
                                         "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_NE(loaded.problems[0].message.find("the node Before gives them"), std::string::npos)
        << loaded.problems[0].message;
}

}  // namespace
