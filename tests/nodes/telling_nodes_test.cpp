// What pictures tell beside what they show: comparisons, burn-in, ghosts, onion skins.

#include "geometry/mesh/primitive.hpp"
#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "nodes/render_burn_in.hpp"
#include "nodes/render_colour.hpp"
#include "nodes/units.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

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

TEST(OnionNode, SaysWhichListedFramesAreNotCooked)
{
    fixtures::NodeRun onion("Onion");
    onion.param("choose").is = std::string("list");
    onion.param("frames").is = std::string("2, 5, 8");
    onion.gathered = {4, 8};  // a cook of the frames 4, 6 and 8
    const auto box = graph::Value::of(geometry::box({1, 1, 1}, {1, 1, 1}));
    onion.inputs["mesh"] = {box, box};
    onion.run();
    ASSERT_EQ(onion.warnings.size(), 2u);
    EXPECT_EQ(onion.warnings[1],
              "frame 5 of `frames` is left out: it is not among those cooked now");
}

TEST(OnionNode, RefusesToTakeMoreThanAThousandFrames)
{
    fixtures::NodeRun onion("Onion");
    onion.param("choose").is = std::string("every");
    onion.param("every").is = std::int64_t{2};
    onion.range.last = 2000;
    EXPECT_EQ(onion.type.gather_frames(onion.params, onion.range).size(), 1000u);
    onion.range.last = 2001;
    EXPECT_THROW(onion.type.gather_frames(onion.params, onion.range), std::invalid_argument);

    const auto loaded = graph::load_text(R"({ "aspic": 1, "frames": { "last": 2001 }, "nodes": {
        "box": { "type": "Primitive@1" },
        "o": { "type": "Onion@1", "inputs": { "mesh": "box.mesh" },
               "params": { "choose": "every", "every": 2 } } } })",
                                         "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_NE(loaded.problems[0].message.find("set `every` to 3 or more"), std::string::npos)
        << loaded.problems[0].message;
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

// ---- Render
// --------------------------------------------------------------------------------------

// Small and bare, from the front: at 9 m and 40 degrees, 96 rows hold 2 * 9 tan 20 = 6.55 m, so
// that a metre has 14.7 pixels.
fixtures::NodeRun bare_picture()
{
    fixtures::NodeRun render("Render");
    render.param("width").is = std::int64_t{96};
    render.param("height").is = std::int64_t{96};
    render.param("look").is = std::string("plain");
    render.param("quality").is = std::string("draft");
    render.param("ground.kind").is = std::string("none");
    render.param("backdrop.top").is = std::array<double, 3>{1, 1, 1};
    render.param("backdrop.horizon").is = std::array<double, 3>{1, 1, 1};
    render.param("light.shadow").is = std::string("off");
    render.param("camera.kind").is = std::string("look_at");
    render.param("camera.eye").is = std::array<double, 3>{0, 0, 9};
    render.param("camera.field_of_view").is = 40.0;
    return render;
}

geometry::TriMesh ball_at(float x)
{
    geometry::TriMesh mesh = geometry::icosphere(0.6, 3);
    for (auto& p : mesh.positions) p.x() += x;
    return mesh;
}

// The red, green and blue of a pixel, x m right of the middle and y m above it.
std::array<int, 3> colour_at(const graph::Value& picture, double x, double y)
{
    const auto image = picture.as<::render::Image>();
    const auto column = std::size_t(48 + 14.66 * x), row = std::size_t(48 - 14.66 * y);
    const auto* const p = &image->rgba[4 * (96 * row + column)];
    return {p[0], p[1], p[2]};
}

TEST(RenderTells, AGhostShowsWhereTheBodyWas)
{
    fixtures::NodeRun render = bare_picture();
    render.inputs["rest"] = {graph::Value::of(ball_at(-1))};
    render.inputs["mesh"] = {graph::Value::of(ball_at(1))};
    const auto without = render.run();
    render.param("show.ghost").is = 0.3;
    const auto with = render.run();
    EXPECT_GT(colour_at(without, -1, 0)[0], 230);  // the backdrop
    EXPECT_LT(colour_at(with, -1, 0)[0], 220);
    EXPECT_GT(colour_at(with, -1, 0)[0], 60);  // and is seen through it
    EXPECT_EQ(colour_at(with, 1, 0), colour_at(without, 1, 0));
    // Where it lies before the body, that keeps its colours.
    render.inputs["mesh"] = {graph::Value::of(ball_at(-0.6f))};
    const auto around = render.run();
    render.param("show.ghost").is = 0.0;
    const auto alone = render.run();
    EXPECT_EQ(colour_at(around, -0.6, 0), colour_at(alone, -0.6, 0));
    EXPECT_EQ(colour_at(around, -0.9, 0.3), colour_at(alone, -0.9, 0.3));
    EXPECT_NE(colour_at(around, -1.4, 0), colour_at(alone, -1.4, 0));
    render.param("show.ghost").is = 1.0;  // nor does it hide the body where it hides all else
    const auto whole = render.run();
    EXPECT_EQ(colour_at(whole, -0.6, 0), colour_at(alone, -0.6, 0));
    EXPECT_EQ(colour_at(whole, -0.9, 0.3), colour_at(alone, -0.9, 0.3));
    EXPECT_NE(colour_at(whole, -1.4, 0), colour_at(alone, -1.4, 0));
    render.param("show.ghost").is = 0.3;
    // What has not moved has none.
    render.inputs["mesh"] = {graph::Value::of(ball_at(-1))};
    const auto still = render.run();
    render.param("show.ghost").is = 0.0;
    EXPECT_EQ(still.as<::render::Image>()->rgba, render.run().as<::render::Image>()->rgba);
}

TEST(RenderTells, AGhostWithoutARestShapeIsRefused)
{
    const auto loaded = graph::load_text(R"({ "aspic": 1, "nodes": {
        "box": { "type": "Primitive@1" },
        "p": { "type": "Render@2", "inputs": { "mesh": "box.mesh" },
               "params": { "show": { "ghost": 0.2 } } } } })",
                                         "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_NE(loaded.problems[0].message.find("link that to `rest`"), std::string::npos);
}

// A green wall before a ball: through half of its opacity the ball is seen.
TEST(RenderTells, WhatLiesBehindAClearColliderIsSeen)
{
    fixtures::NodeRun render = bare_picture();
    physics::Collider wall;
    wall.kind = physics::Collider::Kind::box;
    wall.half_size = {2, 2, 0.1};
    wall.pose.translation() = geometry::Vec3(0, 0, 2);
    render.inputs["mesh"] = {graph::Value::of(ball_at(0))};
    render.inputs["colliders"] = {graph::Value::of(wall)};
    const auto contrast = [&] {
        const auto picture = render.run();
        return std::abs(colour_at(picture, 0, 0)[0] - colour_at(picture, 1.4, 1.4)[0]);
    };
    EXPECT_LT(contrast(), 8);  // nothing but the wall
    render.param("show.collider_opacity").is = 0.3;
    EXPECT_GT(contrast(), 20);
    render.param("show.collider_opacity").is = 0.0;
    EXPECT_GT(colour_at(render.run(), 1.4, 1.4)[0], 230);  // not drawn at all
}

TEST(RenderTells, ForcesSayHowStrongTheyAreWhereTheirTipsAre)
{
    fixtures::NodeRun render = bare_picture();
    physics::Force force;
    force.kind = physics::Force::Kind::point;
    force.force = {0, -120, 0};
    render.inputs["mesh"] = {graph::Value::of(ball_at(0))};
    render.inputs["forces"] = {graph::Value::of(force)};
    const auto without = render.run().as<::render::Image>()->rgba;
    render.param("show.force_values").is = true;
    const auto with = render.run().as<::render::Image>()->rgba;
    int right = 0, elsewhere = 0;
    for (std::size_t i = 0; i < with.size(); i += 4) {
        const std::size_t x = i / 4 % 96, y = i / 4 / 96;
        const bool changed = with[i] != without[i];
        (x > 48 && y > 36 && y < 60 ? right : elsewhere) += changed;
    }
    EXPECT_GT(right, 60);
    EXPECT_EQ(elsewhere, 0);
    render.param("show.forces").is = false;  // nor do these say anything
    const auto hidden = render.run().as<::render::Image>()->rgba;
    render.inputs["forces"].clear();
    EXPECT_EQ(hidden, render.run().as<::render::Image>()->rgba);
}

// A ramp of 0 to 99 and one wild value: by percentile the middle of the ramp has the middle of the
// scale; fitted, all of it has the lowest colour.
TEST(RenderTells, APercentileKeepsTheColoursForMostValues)
{
    fixtures::NodeRun render = bare_picture();
    geometry::TriMesh grid = geometry::grid(4, 4, 9, 9);
    std::vector<float> values;
    for (auto& p : grid.positions) {
        p = {p.x(), p.z(), 0};
        values.push_back(float(values.size()));
    }
    values.back() = 1e6f;
    grid.attributes = {{"heat", "K", values}};
    grid.normals.clear();
    render.inputs["mesh"] = {graph::Value::of(std::move(grid))};
    render.param("colour.by").is = std::string("attribute");
    render.param("colour.attribute").is = std::string("heat");
    render.param("colour.map").is = std::string("grey");
    render.param("legend").is = false;
    const auto contrast = [&] {
        const auto picture = render.run();
        return std::abs(colour_at(picture, 0, 1.5)[1] - colour_at(picture, 0, -1.5)[1]);
    };
    EXPECT_LT(contrast(), 8);
    render.param("colour.range").is = std::string("percentile");
    EXPECT_GT(contrast(), 60);
}

TEST(RenderTells, ALegendSaysWhichShareItShows)
{
    using nodes::render::percentiles_told;
    EXPECT_EQ(percentiles_told(0.02), "2 to 98 %");
    EXPECT_EQ(percentiles_told(0.0123), "1.23 to 98.77 %");
    EXPECT_EQ(percentiles_told(1e-5), "0.001 to 99.999 %");

    nodes::render::ColourParams colour;
    colour.range = nodes::render::ColourParams::Range::percentile;
    geometry::Attribute attribute{"heat", "K", {}};
    for (int i = -20; i <= 80; ++i) attribute.values.push_back(float(i));
    EXPECT_EQ(nodes::render::legend_for(colour, attribute).note, "2 to 98 %");
    EXPECT_EQ(nodes::render::legend_for(colour, attribute).scale.low, -18);
    EXPECT_EQ(nodes::render::legend_for(colour, attribute).scale.high, 78);
    colour.map = ::render::ColourMap::diverging;
    EXPECT_EQ(nodes::render::legend_for(colour, attribute).note, "at least 2 to 98 %");
    EXPECT_EQ(nodes::render::legend_for(colour, attribute).scale.low, -78);
    attribute.values.assign(100, 1.0f);
    attribute.values[7] = 2;
    EXPECT_EQ(nodes::render::legend_for(colour, attribute).note, "");
}

TEST(RenderTells, BurnInWritesWhatIsAskedForAboveTheLabel)
{
    using nodes::render::burn_in_text;
    const auto number = [](double x) { return std::make_shared<const double>(x); };
    EXPECT_EQ(burn_in_text({}, {}, 7, 0.25, "label"), "label");
    EXPECT_EQ(burn_in_text({}, {}, 7, 0.25, ""), "");
    EXPECT_EQ(burn_in_text({"bridge", true, true, 1, ""}, {}, 7, 0.25, "label"),
              "bridge\nframe 7   0.25 s\nlabel");
    // Of ten times slow motion a quarter of a second has taken a fortieth.
    EXPECT_EQ(burn_in_text({"", false, true, 10, ""}, {}, 7, 0.25, ""),
              "0.025 s   slow motion 10x");
    EXPECT_EQ(burn_in_text({"", false, true, 4170, ""}, {}, 7, 0.25, ""),
              "0.000060 s   slow motion 4170x");
    EXPECT_EQ(burn_in_text({"", false, true, 1.0001, ""}, {}, 7, 0.25, ""), "0.25 s");
    EXPECT_EQ(burn_in_text({"", false, true, 0.5, ""}, {}, 7, 0.25, ""), "0.50 s   time lapse 2x");
    EXPECT_EQ(burn_in_text({"", false, false, 1, "tip (m), force (N),stretch"},
                           {number(0.0208), number(1200), number(1.5)}, 7, 0.25, "label"),
              "tip   0.0208 m\nforce   1.2 kN\nstretch   1.5\nlabel");
    EXPECT_EQ(
        burn_in_text({"", false, false, 1, "tip (mm), volume (l), heat (K), sag", "m, m^3, , m"},
                     {number(0.0208), number(2), number(300), number(0.5)}, 7, 0.25, ""),
        "tip   20.8 mm\nvolume   2000 l\nheat   300 K\nsag   0.5 m");
    EXPECT_EQ(burn_in_text({"", false, false, 1, "turn (deg), load (kN)", "rad, N"},
                           {number(1.5707963), number(-2500)}, 7, 0.25, ""),
              "turn   90 deg\nload   -2.5 kN");
    EXPECT_EQ(burn_in_text({}, {number(3), number(4)}, 7, 0.25, ""), "value 1   3\nvalue 2   4");
    try {
        burn_in_text({"", false, false, 1, "tip"}, {number(3), number(4)}, 7, 0.25, "");
        ADD_FAILURE() << "was taken";
    } catch (const std::invalid_argument& error) {
        EXPECT_STREQ(error.what(), "burn_in.names must name each number that is linked to "
                                   "`values`: it has 1 name, for 2 numbers");
    }
}

TEST(RenderTells, NumbersOfMeasureGoIntoThePicture)
{
    const auto small = [](const std::string& more) {
        return R"("params": { "width": 64, "height": 48, "quality": "draft", "burn_in": {)" + more +
               "} }";
    };
    Scene scene(R"(
        "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
        "volume": { "type": "Measure@1", "inputs": { "mesh": "ball.mesh" },
                    "params": { "what": "volume" } },
        "plain": { "type": "Render@2", "inputs": { "mesh": "ball.mesh" }, )" +
                small("") + R"( },
        "area": { "type": "Measure@1", "inputs": { "mesh": "ball.mesh" },
                  "params": { "what": "area" } },
        "told": { "type": "Render@2", "inputs": { "mesh": "ball.mesh",
                                                  "values": ["volume.value", "area.value"] }, )" +
                small(R"("names": "volume, area")") + R"( },
        "unnamed": { "type": "Render@2", "inputs": { "mesh": "ball.mesh",
                                                     "values": ["volume.value", "area.value"] }, )" +
                small("") + R"( },
        "one": { "type": "Render@2", "inputs": { "mesh": "ball.mesh", "values": ["area.value"] },
                 "params": { "width": 64, "height": 48, "quality": "draft" } },
        "other": { "type": "Render@2", "inputs": { "mesh": "ball.mesh", "values": ["area.value"] }, )" +
                small(R"("names": "other")") + " }");
    const auto picture = [&](const char* node) { return scene.at<::render::Image>(node)->rgba; };
    EXPECT_NE(picture("told"), picture("plain"));
    EXPECT_EQ(picture("told"), picture("unnamed"));  // by the nodes that they come from
    EXPECT_NE(picture("one"), picture("other"));
}

// 0.5 m of radius: 3.14 m^2.
TEST(RenderTells, UnitsOfMeasureAreThoseInThePicture)
{
    const auto loaded = [](const char* burn_in) {
        return graph::load_text(R"({ "aspic": 1, "nodes": {
            "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
            "area": { "type": "Measure@1", "inputs": { "mesh": "ball" },
                      "params": { "what": "area" } },
            "count": { "type": "Measure@1", "inputs": { "mesh": "ball" },
                       "params": { "what": "vertices" } },
            "p": { "type": "Render@2", "inputs": { "mesh": "ball", "values": ["count", "area"] },
                   "params": { "burn_in": {)" +
                                    std::string(burn_in) + "} } } } }",
                                "scene.json", nodes::registry());
    };
    const auto units = [](const graph::Graph& graph) {
        const graph::Node& render = *std::find_if(graph.nodes.begin(), graph.nodes.end(),
                                                  [](const auto& n) { return n.name == "p"; });
        nodes::render::BurnInParams out;
        for (std::size_t k = 0; k < render.params.size(); ++k) {
            if (render.type->params[k].name != "burn_in") continue;
            out.units =
                std::get<std::string>(std::get<graph::ParamValues>(render.params[k].is).back().is);
        }
        return out.units;
    };
    EXPECT_EQ(units(loaded("").graph), ",m^2");
    EXPECT_EQ(units(loaded(R"("units": "1,cm^2")").graph), "1,cm^2");
    EXPECT_TRUE(loaded(R"-("names": "n, area (cm^2)")-").problems.empty());
    const auto wrong = loaded(R"-("names": "n (of all), area (mm)")-");
    ASSERT_EQ(wrong.problems.size(), 1u);
    EXPECT_NE(wrong.problems[0].message.find("`area` is in m^2, which `mm` is no unit of"),
              std::string::npos)
        << wrong.problems[0].message;
    EXPECT_EQ(loaded(R"("units": "m^2")").problems.size(), 1u);
}

TEST(RenderTells, NamesWithoutNumbersAreRefused)
{
    const auto loaded = graph::load_text(R"({ "aspic": 1, "nodes": {
        "box": { "type": "Primitive@1" },
        "p": { "type": "Render@2", "inputs": { "mesh": "box.mesh" },
               "params": { "burn_in": { "names": "volume" } } } } })",
                                         "scene.json", nodes::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_NE(loaded.problems[0].message.find("it has 1 name, for 0 numbers"), std::string::npos);
}

TEST(Units, AreThoseOfTheQuantityThatAMeasureHas)
{
    const auto loaded = graph::load_text(R"({ "aspic": 1, "nodes": {
        "ball": { "type": "Primitive@1", "params": { "shape": "sphere" } },
        "size": { "type": "Measure@1", "inputs": { "mesh": "ball.mesh" },
                  "params": { "what": "volume" } },
        "faces": { "type": "Measure@1", "inputs": { "mesh": "ball.mesh" },
                   "params": { "what": "triangles" } },
        "usual": { "type": "Measure@1", "inputs": { "mesh": "ball.mesh", "rest": "ball.mesh" } } } })",
                                         "units.json", nodes::registry());
    std::map<std::string, std::string> units;
    for (const graph::Node& node : loaded.graph.nodes) units[node.name] = nodes::unit_of(node);
    EXPECT_EQ(units["size"], "m^3");
    EXPECT_EQ(units["usual"], "m");  // displacement_max
    EXPECT_EQ(units["faces"], "");
    EXPECT_EQ(units["ball"], "");
}

}  // namespace
