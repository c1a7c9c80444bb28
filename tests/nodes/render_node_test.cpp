// What Render holds in its picture, and what it says of one that can show nothing.

#include "geometry/mesh/primitive.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using fixtures::NodeRun;
using geometry::Vec3f;

// A small picture of a mesh that has moved from where it was at rest.
NodeRun picture_of_moved(const geometry::TriMesh& rest, const Vec3f& by)
{
    geometry::TriMesh mesh = rest;
    for (Vec3f& p : mesh.positions) p += by;
    NodeRun render("Render");
    render.inputs["rest"] = {graph::Value::of(geometry::TriMesh(rest))};
    render.inputs["mesh"] = {graph::Value::of(std::move(mesh))};
    render.param("width").is = std::int64_t{32};
    render.param("height").is = std::int64_t{32};
    return render;
}

TEST(RenderNode, WarnsOfAnEmptyPicture)
{
    const geometry::TriMesh rest = geometry::grid(1, 1, 2, 2);
    const auto warnings = [&](const Vec3f& moved, const char* camera) {
        NodeRun render = picture_of_moved(rest, moved);
        render.param("camera.kind").is = std::string(camera);
        render.param("camera.eye").is = std::array<double, 3>{0, 0, 9};
        render.param("camera.target").is = std::array<double, 3>{0, 0, 0};
        render.run();
        return render.warnings;
    };
    for (const char* camera : {"fit", "look_at"}) {
        EXPECT_TRUE(warnings({0, 0, 0}, camera).empty()) << camera;
        const auto gone = warnings({0, -40, 0}, camera);
        ASSERT_EQ(gone.size(), 1u) << camera;
        EXPECT_NE(gone[0].find("no linked mesh lies in the picture"), std::string::npos);
    }
    EXPECT_NE(warnings({0, -40, 0}, "look_at")[0].find("camera.target"), std::string::npos);
}

TEST(RenderNode, WarnsOnceOfLettersThatAreBoxes)
{
    NodeRun render = picture_of_moved(geometry::uv_sphere(1, 8, 16), {0, 0, 0});
    render.param("label").is = std::string("Größe Ω");
    render.run();
    EXPECT_TRUE(render.warnings.empty());
    render.param("label").is = std::string("漢字 漢");
    render.run();
    ASSERT_EQ(render.warnings.size(), 1u);
    EXPECT_NE(render.warnings[0].find("no glyphs for 漢字:"), std::string::npos);
}

TEST(RenderNode, WarnsOfWhatItsGroundHides)
{
    const geometry::TriMesh rest = geometry::uv_sphere(1, 8, 16);
    const auto warnings = [&](float down, const char* ground) {
        NodeRun render = picture_of_moved(rest, {0, -down, 0});
        render.param("ground.kind").is = std::string(ground);
        render.param("ground.height").is = -1.0;
        render.run();
        return render.warnings;
    };
    EXPECT_TRUE(warnings(0, "under").empty());
    EXPECT_TRUE(warnings(0.1f, "under").empty());
    EXPECT_TRUE(warnings(0.8f, "none").empty());
    EXPECT_TRUE(warnings(0.8f, "at").empty());
    const auto hidden = warnings(0.8f, "under");
    ASSERT_EQ(hidden.size(), 1u);
    EXPECT_NE(hidden[0].find("it is at -1 m"), std::string::npos) << hidden[0];
    // The likeliest way out comes first.
    const std::size_t link =
        hidden[0].find("Link the Ground on which the mesh falls to `colliders`");
    EXPECT_LT(link, hidden[0].find("MotionBounds")) << hidden[0];
    EXPECT_LT(link, hidden[0].find("ground.kind")) << hidden[0];
}

TEST(RenderNode, AMeshWithoutTheAttributeOfTheOthersKeepsItsMaterial)
{
    const auto ball_at = [](float x) {
        geometry::TriMesh mesh = geometry::icosphere(0.5, 2);
        for (Vec3f& p : mesh.positions) p.x() += x;
        return mesh;
    };
    geometry::TriMesh plain = ball_at(-0.6f), hot = ball_at(0.6f);
    auto topology = *plain.topology;
    topology.materials = {geometry::Material{"red", {0.9f, 0, 0}}};
    plain.topology = std::make_shared<const geometry::MeshTopology>(topology);
    hot.attributes.push_back({"heat", "", std::vector<float>(hot.positions.size(), 1.0f)});
    NodeRun render("Render");
    render.param("width").is = std::int64_t{32};
    render.param("height").is = std::int64_t{32};
    render.param("colour.by").is = std::string("attribute");
    render.param("colour.attribute").is = std::string("heat");
    render.param("legend").is = false;
    const auto red_pixels = [&] {
        const auto image = render.run().as<::render::Image>();
        int count = 0;
        for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
            count += int(image->rgba[i]) - int(image->rgba[i + 1]) > 80 ? 1 : 0;
        }
        return count;
    };
    render.inputs["mesh"] = {graph::Value::of(plain), graph::Value::of(hot)};
    EXPECT_GT(red_pixels(), 20);
    render.inputs["mesh"] = {graph::Value::of(hot)};
    EXPECT_EQ(red_pixels(), 0);
    render.inputs["mesh"] = {graph::Value::of(plain)};
    EXPECT_THROW(render.run(), std::exception);  // nothing has it
    // The displacement is that of the mesh which is like `rest`.
    render.param("colour.attribute").is = std::string("displacement");
    geometry::TriMesh floor = geometry::grid(3, 3, 1, 1);
    floor.topology = std::make_shared<const geometry::MeshTopology>([&] {
        auto own = *floor.topology;
        own.materials = topology.materials;
        return own;
    }());
    render.inputs["rest"] = {graph::Value::of(hot)};
    render.inputs["mesh"] = {graph::Value::of(hot), graph::Value::of(floor)};
    EXPECT_GT(red_pixels(), 20);
    // Nor does it matter whether cubes or a mesh have it.
    render.param("colour.attribute").is = std::string("fill");
    render.param("cube.draw").is = std::string("solid");
    render.param("cube.by_attribute").is = true;
    render.inputs["cubes"] = {graph::Value::of(fixtures::box(1, 1, 1, 0.1))};
    render.inputs["mesh"] = {graph::Value::of(floor)};
    EXPECT_GT(red_pixels(), 20);
}

// Balls of 1 and of 10, and cubes of 1: on the scale from 0 to 10, what has 1 is dark violet. On
// one that is fitted to 1 it would be yellow, as what has 10.
TEST(RenderNode, OneScaleHoldsTheValuesOfAllThatIsDrawn)
{
    const auto ball = [](float x, float value) {
        geometry::TriMesh mesh = geometry::icosphere(0.5, 2);
        for (Vec3f& p : mesh.positions) p.x() += x;
        mesh.attributes = {{"fill", "", std::vector<float>(mesh.positions.size(), value)}};
        return graph::Value::of(std::move(mesh));
    };
    NodeRun render("Render");
    render.param("width").is = std::int64_t{64};
    render.param("height").is = std::int64_t{32};
    render.param("look").is = std::string("plain");
    render.param("ground.kind").is = std::string("none");
    render.param("colour.by").is = std::string("attribute");
    render.param("colour.attribute").is = std::string("fill");
    render.param("legend").is = false;
    const auto yellow_pixels = [&] {
        const auto image = render.run().as<::render::Image>();
        int count = 0;
        for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
            count += int(image->rgba[i]) - int(image->rgba[i + 2]) > 80 ? 1 : 0;
        }
        return count;
    };
    const graph::Value low = ball(-0.6f, 1), high = ball(0.6f, 10);
    render.inputs["mesh"] = {low};
    EXPECT_GT(yellow_pixels(), 100) << "alone, it fits its scale";
    render.inputs["mesh"] = {high, low};
    const int one = yellow_pixels();
    EXPECT_GT(one, 50);
    render.inputs["mesh"] = {low, high};
    EXPECT_EQ(yellow_pixels(), one);
    for (const char* range : {"fit", "percentile"}) {
        render.param("colour.range").is = std::string(range);
        // The cubes are 1.
        render.inputs["mesh"] = {ball(-2, 10)};
        render.inputs["cubes"] = {graph::Value::of(fixtures::box(2, 2, 2, 0.5))};
        render.param("cube.draw").is = std::string("solid");
        render.param("cube.by_attribute").is = true;
        const int of_ball = yellow_pixels();
        render.inputs["mesh"] = {ball(-2, 0.1f)};
        const int of_cubes = yellow_pixels();
        EXPECT_GT(of_ball, 20) << range;
        EXPECT_GT(of_cubes, of_ball) << range << ": these are larger, and the ball is dark now";
        render.inputs["mesh"] = {ball(-2, 1)};
        EXPECT_GT(yellow_pixels(), of_cubes + of_ball / 2) << range << ": both at the upper end";
    }
}

// Balls of 0.6 m about points 2 m apart: a share of 0.1 is free beside the outermost on one side
// at least, and nowhere less.
TEST(RenderNode, ACameraThatFitsHoldsTheBallsOfPoints)
{
    geometry::TriMesh cloud;
    for (const float x : {-1.0f, 1.0f}) {
        for (const float y : {-1.0f, 1.0f}) cloud.positions.emplace_back(x, y, 0.0f);
    }
    NodeRun render("Render");
    render.inputs["mesh"] = {graph::Value::of(cloud)};
    render.param("width").is = std::int64_t{100};
    render.param("height").is = std::int64_t{100};
    render.param("look").is = std::string("plain");
    render.param("ground.kind").is = std::string("none");
    render.param("backdrop.top").is = std::array<double, 3>{0, 0, 0};
    render.param("backdrop.horizon").is = std::array<double, 3>{0, 0, 0};
    render.param("camera.azimuth").is = 0.0;
    render.param("camera.elevation").is = 0.0;
    render.param("camera.margin").is = 0.1;
    render.param("show.point_size").is = 0.6;
    for (const bool rest : {false, true}) {
        if (rest) render.inputs["rest"] = {graph::Value::of(cloud)};
        for (const char* kind : {"fit", "turntable"}) {
            render.param("camera.kind").is = std::string(kind);
            const auto image = render.run().as<::render::Image>();
            std::size_t least = 100, most = 0;
            for (std::size_t i = 0; i < 100 * 100; ++i) {
                if (image->rgba[4 * i] < 20) continue;
                least = std::min({least, i % 100, i / 100});
                most = std::max({most, i % 100, i / 100});
            }
            EXPECT_GE(least, 9u) << kind << rest;
            EXPECT_LE(most, 90u) << kind << rest;
            EXPECT_LE(least, rest ? 16u : 20u) << kind << rest;
        }
    }
}

TEST(RenderNode, SaysWhyColoursAreNotKnown)
{
    NodeRun render("Render");
    render.param("width").is = std::int64_t{32};
    render.param("height").is = std::int64_t{32};
    render.param("colour.by").is = std::string("attribute");
    geometry::TriMesh ball = geometry::icosphere(0.5, 1);
    render.inputs["mesh"] = {graph::Value::of(ball)};
    const auto why = [&] {
        try {
            render.run();
        } catch (const std::invalid_argument& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(why().find("link the mesh at rest to `rest`"), std::string::npos) << why();
    render.inputs["rest"] = {graph::Value::of(geometry::icosphere(0.5, 2))};
    EXPECT_NE(why().find("has 162 vertices where the mesh has 42"), std::string::npos) << why();
    render.inputs["rest"] = {graph::Value::of(ball)};
    EXPECT_EQ(why(), "");
    render.param("colour.by").is = std::string("vertex");
    EXPECT_EQ(why(), "");
    ASSERT_EQ(render.warnings.size(), 1u);
    EXPECT_NE(render.warnings[0].find("drawn in their materials"), std::string::npos);
    ball.colours.assign(ball.positions.size(), Vec3f(1, 0, 0));
    render.inputs["mesh"].push_back(graph::Value::of(ball));
    EXPECT_EQ(why(), "");
    EXPECT_EQ(render.warnings.size(), 1u);
}

// Also where one end is the default or moves, which only a run knows.
TEST(RenderNode, ARangeOfColoursThatRunsDownIsRefused)
{
    geometry::TriMesh ball = geometry::icosphere(0.5, 1);
    ball.attributes = {{"heat", "K", std::vector<float>(ball.positions.size(), 3)}};
    NodeRun render("Render");
    render.inputs["mesh"] = {graph::Value::of(std::move(ball))};
    render.param("width").is = std::int64_t{32};
    render.param("height").is = std::int64_t{32};
    render.param("colour.by").is = std::string("attribute");
    render.param("colour.attribute").is = std::string("heat");
    render.param("colour.range").is = std::string("fixed");
    render.param("colour.high").is = 5.0;
    EXPECT_NO_THROW(render.run());
    for (const double low : {5.0, 20.0, 5 - 1e-9}) {  // as the scale's floats, the last is 5
        render.param("colour.low").is = low;
        EXPECT_THROW(render.run(), std::exception) << low;
    }
    render.param("colour.range").is = std::string("fit");
    EXPECT_NO_THROW(render.run());
}

// A long yellow bar of matter that fills the width of its picture ends beside the scale, whose
// middle is teal: in one picture, and in the upper right one of four, where letters are larger for
// its size.
TEST(RenderNode, ACameraThatFitsLeavesTheLegendItsRoomInFourViewsToo)
{
    geometry::TriMesh bar = geometry::box({4, 0.5, 0.5}, {1, 1, 1});
    bar.attributes = {{"heat", "K", std::vector<float>(bar.positions.size(), 1)}};
    NodeRun render("Render");
    render.param("width").is = std::int64_t{480};
    render.param("height").is = std::int64_t{270};
    render.param("look").is = std::string("plain");
    render.param("quality").is = std::string("draft");
    render.param("ground.kind").is = std::string("none");
    render.param("camera.azimuth").is = 0.0;
    render.param("camera.elevation").is = 0.0;
    render.param("colour.by").is = std::string("attribute");
    render.param("colour.attribute").is = std::string("heat");
    render.inputs["mesh"] = {graph::Value::of(std::move(bar))};
    for (const bool four : {false, true}) {
        render.param("camera.views").is = std::string(four ? "four" : "one");
        const auto image = render.run().as<::render::Image>();
        int last_of_bar = 0, first_of_scale = 480;
        for (int x = four ? 242 : 0; x < 480; ++x) {
            const auto* p = &image->rgba[4 * std::size_t(480 * (four ? 67 : 135) + x)];
            if (int(p[0]) - int(p[2]) > 80) last_of_bar = x;
            if (int(p[1]) - int(p[0]) > 60) first_of_scale = std::min(first_of_scale, x);
        }
        EXPECT_GT(last_of_bar, 0) << four;
        EXPECT_LT(first_of_scale, 480) << four;
        EXPECT_GT(first_of_scale, last_of_bar + 3) << four;
    }
}

// Two points of a cloud, one red and one blue, 1 m apart and 0.5 m wide, fill what balls of that
// size do: at 9 m and 40 degrees, 64 pixels high, 0.5 m are 64 * 0.5 / (2 * 9 tan 20) = 4.9 pixels,
// and a ball covers pi / 4 of its square, 19 pixels.
TEST(RenderNode, ACloudIsDrawnAsBallsInItsColours)
{
    geometry::TriMesh cloud;
    cloud.positions = {{-0.5f, 0, 0}, {0.5f, 0, 0}};
    cloud.colours = {{1, 0, 0}, {0, 0, 1}};
    NodeRun render("Render");
    render.inputs["mesh"] = {graph::Value::of(std::move(cloud))};
    render.param("width").is = std::int64_t{64};
    render.param("height").is = std::int64_t{64};
    render.param("look").is = std::string("plain");
    render.param("quality").is = std::string("draft");
    render.param("ground.kind").is = std::string("none");
    render.param("show.point_size").is = 0.5;
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.eye").is = std::array<double, 3>{0, 0, 9};
    render.param("camera.target").is = std::array<double, 3>{0, 0, 0};
    render.param("camera.field_of_view").is = 40.0;
    const auto image = render.run().as<::render::Image>();
    int red = 0, blue = 0;
    for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
        const int r = image->rgba[i], b = image->rgba[i + 2];
        if (r > 2 * b + 20) (i / 4 % 64 < 32 ? red : blue) += 1;
        if (b > 2 * r + 20) (i / 4 % 64 < 32 ? red : blue) += 100;
    }
    EXPECT_NEAR(red, 19, 6);
    EXPECT_NEAR(blue, 1900, 600);
}

// A wall 4 m wide and high in squares of 1 m: pale and dark change places at each metre, and stay
// on the wall as it moves. With texture coordinates from 0 to 1, four squares a unit are as large.
TEST(RenderNode, CheckersAreSquaresThatStickToTheSurface)
{
    geometry::TriMesh wall;
    wall.positions = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}};
    geometry::MeshTopology topology;
    topology.triangles = {{0, 1, 2}, {0, 2, 3}};
    wall.topology = std::make_shared<const geometry::MeshTopology>(topology);
    NodeRun render("Render");
    for (const char* side : {"width", "height"}) render.param(side).is = std::int64_t{100};
    render.param("look").is = std::string("plain");
    render.param("quality").is = std::string("draft");
    render.param("ground.kind").is = std::string("none");
    render.param("light.shadow").is = std::string("off");
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.parallel").is = true;
    render.param("camera.eye").is = std::array<double, 3>{0, 0, 5};
    render.param("camera.target").is = std::array<double, 3>{0, 0, 0};
    // 5 m are seen: 20 pixels a metre.
    render.param("camera.field_of_view").is = 2 * std::atan(0.5) * 180 / 3.141592653589793;
    render.param("colour.by").is = std::string("checker");
    render.param("colour.square").is = 1.0;
    render.param("colour.squares").is = 4.0;
    const auto pattern = [&](const geometry::TriMesh& mesh, float by) {
        geometry::TriMesh moved = mesh;
        for (Vec3f& p : moved.positions) p.x() += by;
        render.inputs["rest"] = {graph::Value::of(geometry::TriMesh(mesh))};
        render.inputs["mesh"] = {graph::Value::of(std::move(moved))};
        const auto image = render.run().as<::render::Image>();
        std::string rows;
        for (const double y : {1.5, 0.5, -0.5, -1.5}) {
            for (const double x : {-1.5, -0.5, 0.5, 1.5}) {
                const auto column = std::size_t(50 + 20 * (x + double(by))),
                           row = std::size_t(50 - 20 * y);
                rows += image->rgba[4 * (100 * row + column)] > 130 ? '#' : '.';
            }
        }
        return rows;
    };
    const std::string even = "#.#..#.##.#..#.#", odd = ".#.##.#..#.##.#.";
    const std::string by_place = pattern(wall, 0);
    EXPECT_TRUE(by_place == even || by_place == odd) << by_place;
    EXPECT_EQ(pattern(wall, 0.3f), by_place);
    topology.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    topology.uv_triangles = topology.triangles;
    wall.topology = std::make_shared<const geometry::MeshTopology>(topology);
    render.param("colour.square").is = 0.1;
    const std::string by_uv = pattern(wall, 0);
    EXPECT_TRUE(by_uv == even || by_uv == odd) << by_uv;
    EXPECT_EQ(pattern(wall, 0.3f), by_uv);
}

// Two balls 4 m apart along the view: in parallel both are as large, and a metre at the target has
// as many pixels as in perspective, 96 / (2 * 9 tan 20) = 14.7.
TEST(RenderNode, ACameraThatLooksAtATargetMayBeParallel)
{
    geometry::TriMesh near = geometry::icosphere(0.5, 3), far = near;
    for (Vec3f& p : near.positions) p += Vec3f(-1, 0, 2);
    for (Vec3f& p : far.positions) p += Vec3f(1, 0, -2);
    NodeRun render("Render");
    for (const char* side : {"width", "height"}) render.param(side).is = std::int64_t{96};
    render.param("look").is = std::string("plain");
    render.param("quality").is = std::string("draft");
    render.param("ground.kind").is = std::string("none");
    render.param("backdrop.top").is = std::array<double, 3>{0, 0, 1};
    render.param("backdrop.horizon").is = std::array<double, 3>{0, 0, 1};
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.eye").is = std::array<double, 3>{0, 0, 9};
    render.param("camera.target").is = std::array<double, 3>{0, 0, 0};
    render.param("camera.field_of_view").is = 40.0;
    render.inputs["mesh"] = {graph::Value::of(near), graph::Value::of(far)};
    const auto widths = [&] {
        const auto image = render.run().as<::render::Image>();
        std::array<int, 2> found{};
        for (std::size_t x = 0; x < 96; ++x) {
            const auto* p = &image->rgba[4 * (96 * 48 + x)];
            if (std::abs(int(p[0]) - int(p[2])) < 60) ++found[x < 48 ? 0 : 1];
        }
        return found;
    };
    const auto perspective = widths();
    EXPECT_GT(perspective[0], perspective[1] + 4);
    render.param("camera.parallel").is = true;
    const auto parallel = widths();
    EXPECT_NEAR(parallel[0], 14.7, 1.5);
    EXPECT_NEAR(parallel[1], 14.7, 1.5);
    // Beside three others, it is the upper right part.
    render.param("camera.views").is = std::string("four");
    render.param("width").is = std::int64_t{194};
    render.param("height").is = std::int64_t{194};
    const auto four = render.run().as<::render::Image>();
    render.param("camera.views").is = std::string("one");
    render.param("width").is = std::int64_t{96};
    render.param("height").is = std::int64_t{96};
    const auto one = render.run().as<::render::Image>();
    for (std::size_t y = 0; y < 96; ++y) {
        EXPECT_TRUE(std::equal(one->rgba.begin() + std::ptrdiff_t(4 * 96 * y),
                               one->rgba.begin() + std::ptrdiff_t(4 * 96 * (y + 1)),
                               four->rgba.begin() + std::ptrdiff_t(4 * (194 * y + 98))));
    }
}

// A ball that flies 3 m in 10 frames: the camera that holds its motion keeps the margin free in all
// of them, and no more on one side at least.
TEST(RenderNode, HoldsTheMotionOfAllFrames)
{
    const auto ball = [](int frame) {
        geometry::TriMesh mesh = geometry::icosphere(0.3, 3);
        const float t = float(frame - 1) / 9;
        for (Vec3f& p : mesh.positions) p += Vec3f(3 * t, 2 * t * (1 - t), -t);
        return graph::Value::of(std::move(mesh));
    };
    NodeRun bounds("MotionBounds");
    for (int frame = 1; frame <= 10; ++frame) bounds.inputs["mesh"].push_back(ball(frame));
    const graph::Value shot = bounds.run();

    constexpr int width = 200, height = 120;
    const auto edges = [&](bool hold_motion) {
        int left = width, right = -1, top = height, bottom = -1;
        for (int frame = 1; frame <= 10; ++frame) {
            NodeRun render("Render");
            render.inputs["mesh"] = {ball(frame)};
            render.inputs["rest"] = {ball(1)};
            if (hold_motion) render.inputs["shot"] = {shot};
            render.param("width").is = std::int64_t{width};
            render.param("height").is = std::int64_t{height};
            render.param("look").is = std::string("plain");
            render.param("quality").is = std::string("draft");
            render.param("ground.kind").is = std::string("none");
            render.param("backdrop.top").is = std::array<double, 3>{0, 0, 1};
            render.param("backdrop.horizon").is = std::array<double, 3>{0, 0, 1};
            render.param("camera.margin").is = 0.1;
            const graph::Value value = render.run(frame);
            const auto& image = *value.as<::render::Image>();
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) {
                    const auto i = 4 * std::size_t(y * width + x);
                    if (image.rgba[i + 2] > image.rgba[i] + 40) continue;  // the backdrop
                    left = std::min(left, x), right = std::max(right, x);
                    top = std::min(top, y), bottom = std::max(bottom, y);
                }
            }
        }
        return std::array{left, width - 1 - right, top, height - 1 - bottom};
    };
    const std::array<int, 4> held = edges(true);
    // 162 directions miss the outline of a ball by 1.2 % of its diameter: less than a pixel.
    for (const std::size_t side : {0u, 1u}) EXPECT_NEAR(held[side], 0.1 * width, 1.5);
    for (const std::size_t side : {2u, 3u}) EXPECT_GE(held[side], 0.1 * height - 1.5);
    EXPECT_EQ(edges(false)[1], 0) << "held at rest alone, it leaves on the right";
}

}  // namespace
