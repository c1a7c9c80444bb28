// The nodes that make and follow layered bodies, on values that are known beforehand.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using graph::Value;
using physics::BaseKind;
using physics::LayeredPart;
using physics::LayeredScene;

// Point skeletons of thickness 0.1, each on its own frame.
Value part_of(const std::vector<Vec3>& points, BaseKind kind)
{
    geometry::ImplicitLayer layer;
    for (const Vec3& p : points) {
        layer.frame.push_back(static_cast<std::uint32_t>(layer.skeletons.size()));
        layer.skeletons.push_back({.kind = geometry::SkeletonKind::point, .points = {p}});
        layer.contributions.push_back({.thickness = 0.1, .stiffness = 10, .radius = 0.22});
    }
    LayeredPart part;
    part.body = std::make_shared<const physics::LayeredBody>(
        physics::make_layered_body(layer, kind, 1000, 0.02));
    return Value::of(part);
}

}  // namespace

TEST(Layered, TellsOfAPointForceFarFromAllLayers)
{
    const auto warnings = [](const Vec3& position) {
        NodeRun node("Layered");
        node.inputs["parts"] = {part_of({{0, 0, 0}}, BaseKind::rigid)};
        physics::Force force;
        force.kind = physics::Force::Kind::point;
        force.force = {1, 0, 0};
        force.position = position;
        force.radius = 0.1;
        node.inputs["forces"] = {Value::of(force)};
        node.run();
        return node.warnings;
    };
    EXPECT_TRUE(warnings({0.15, 0, 0}).empty());
    ASSERT_EQ(warnings({50, 0, 0}).size(), 1u);
    EXPECT_NE(warnings({50, 0, 0})[0].find("no layer within its radius"), std::string::npos);
}

TEST(Springs, JoinFramesInReachAndRefuseAnEmptyNetwork)
{
    NodeRun springs("Springs");
    springs.inputs["part"] = {
        part_of({{0, 0, 0}, {0.2, 0, 0}, {0.2, 0.3, 0}}, BaseKind::particles)};
    springs.param("reach").is = 0.25;
    springs.param("stiffness").is = 700.0;
    springs.param("damping").is = 3.0;
    const auto part = springs.run().as<LayeredPart>();
    ASSERT_EQ(part->body->base.springs.size(), 1u);
    const physics::LayerSpring& spring = part->body->base.springs[0];
    EXPECT_EQ(spring.a, 0u);
    EXPECT_EQ(spring.b, 1u);
    EXPECT_NEAR(spring.rest, 0.2, 1e-12);
    EXPECT_EQ(spring.stiffness, 700);
    EXPECT_EQ(spring.damping, 3);
    EXPECT_EQ(part->body->base.substance.stiffness, 0) << "particles no longer act on each other";

    springs.param("reach").is = 0.1;
    try {
        springs.run();
        FAIL() << "no two frames are 0.1 m near";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("raise reach"), std::string::npos);
    }
}

// Where nothing touches, each vertex is carried by its frame and keeps its value of the field.
TEST(Skin, FollowsTheMotionAndTheTargetVolumeOfItsBody)
{
    const Value part = part_of({{0, 0, 0}}, BaseKind::still);
    const geometry::TriMesh ball = geometry::icosphere(0.11, 3);
    NodeRun skin("Skin");
    skin.inputs["mesh"] = {Value::of(ball)};
    skin.inputs["part"] = {part};
    LayeredScene scene = physics::start({*part.as<LayeredPart>()});
    skin.inputs["scene"] = {Value::of(scene)};
    auto mesh = skin.run().as<geometry::TriMesh>();
    ASSERT_EQ(mesh->positions.size(), ball.positions.size());
    for (std::size_t v = 0; v < ball.positions.size(); ++v) {
        EXPECT_LT((mesh->positions[v] - ball.positions[v]).norm(), 1e-6f);
    }
    // Moved, and blown up by 0.02: surfaces of equal field lie that much farther out.
    scene.states[0].position[0] += Vec3(1, 2, 3);
    scene.states[0].translation[0] = 0.02;
    skin.inputs["scene"] = {Value::of(scene)};
    mesh = skin.run().as<geometry::TriMesh>();
    for (std::size_t v = 0; v < ball.positions.size(); ++v) {
        const Vec3 at = mesh->positions[v].cast<double>() - Vec3(1, 2, 3);
        EXPECT_NEAR(at.norm(), 0.13, 1e-5);
        EXPECT_GT(at.normalized().dot(ball.positions[v].cast<double>().normalized()), 1 - 1e-9);
    }
    EXPECT_TRUE(skin.warnings.empty());
    EXPECT_EQ(mesh->triangles(), ball.triangles());
}

TEST(ImplicitLayer, FindsMusclesByTheIndexOfTheirSkeleton)
{
    geometry::ImplicitLayer layer;
    for (const double x : {0.0, 0.5}) {
        layer.frame.push_back(0);
        layer.skeletons.push_back({.kind = geometry::SkeletonKind::point, .points = {{x, 0, 0}}});
        layer.contributions.push_back({.thickness = 0.1, .stiffness = 10, .radius = 0.22});
    }
    NodeRun node("ImplicitLayer");
    node.inputs["layer"] = {Value::of(layer)};
    node.param("inflation").is = 1.5;
    EXPECT_TRUE(node.run().as<LayeredPart>()->muscle.empty());
    const auto flex = [&](std::int64_t skeleton, std::size_t times = 1) {
        const graph::ParamValue muscle{graph::ParamValues{{skeleton}, {2.0}}};
        node.param("muscles").is = graph::ParamValues(times, muscle);
        return node.run().as<LayeredPart>();
    };
    EXPECT_EQ(flex(1)->muscle, (std::vector<double>{1, 2}));
    EXPECT_EQ(flex(0, 3)->muscle, (std::vector<double>{8, 1}));  // one after the other
    EXPECT_EQ(flex(1)->sought(0), 1.5);
    EXPECT_EQ(flex(1)->sought(1), 3);
    EXPECT_THROW(flex(2), std::invalid_argument);
}

TEST(Skin, WarnsOfVerticesOutsideTheLayersRadius)
{
    const Value part = part_of({{0, 0, 0}}, BaseKind::still);
    NodeRun skin("Skin");
    const geometry::TriMesh far = geometry::icosphere(0.3, 0);  // beyond the radius of 0.22
    skin.inputs["mesh"] = {Value::of(far)};
    skin.inputs["part"] = {part};
    skin.inputs["scene"] = {Value::of(physics::start({*part.as<LayeredPart>()}))};
    skin.run();
    ASSERT_EQ(skin.warnings.size(), 1u);
    EXPECT_NE(skin.warnings[0].find("12 of 12"), std::string::npos) << skin.warnings[0];
}

TEST(Carry, AcceptsOnlyTheInputsOfItsMover)
{
    const Value part = part_of({{0.1, 0.1, 0.1}}, BaseKind::still);
    const geometry::Cubes cubes = geometry::solid_cubes({{0, 0, 0}, {1, 0, 0}}, 0.2);
    physics::State state;
    state.x = geometry::corner_positions(cubes);
    for (Vec3& x : state.x) x.y() += 1;
    const Value pins = Value::of(physics::Pins{{3}, {Vec3(1, 2, 3)}});

    NodeRun carry("Carry");
    carry.inputs["part"] = {part};
    carry.inputs["cubes"] = {Value::of(cubes)};
    EXPECT_THROW(carry.run(), std::invalid_argument) << "nobody says where the cubes are";
    carry.inputs["state"] = {Value::of(state)};
    const auto led = carry.run().as<LayeredPart>();
    EXPECT_EQ(led->body->base.kind, BaseKind::led);
    ASSERT_EQ(led->frames.size(), 1u);
    EXPECT_LT((led->frames[0].translation() - Vec3(0, 1, 0)).norm(), 1e-6);
    carry.inputs["pins"] = {pins};
    EXPECT_THROW(carry.run(), std::invalid_argument) << "pins are Simulate's";

    carry.param("moved_by").is = std::string("layered");
    EXPECT_THROW(carry.run(), std::invalid_argument) << "Layered says where the cubes are";
    carry.inputs.erase("state");
    const auto moved = carry.run().as<LayeredPart>();
    EXPECT_EQ(moved->body->base.kind, BaseKind::carried);
    EXPECT_EQ(moved->pins.corner, std::vector<std::uint32_t>{3});

    NodeRun carried("Carried");
    carried.inputs["scene"] = {Value::of(physics::start({*led, *moved}))};
    EXPECT_THROW(carried.run(), std::invalid_argument) << "those cubes are Simulate's";
    carried.param("part").is = std::int64_t{1};
    EXPECT_EQ(carried.run().as<physics::State>()->x, geometry::corner_positions(cubes));
    carried.param("part").is = std::int64_t{2};
    EXPECT_THROW(carried.run(), std::invalid_argument) << "there are two";
}

TEST(ImplicitLayer, WarnsOfInflationWithoutVolumeControl)
{
    geometry::ImplicitLayer layer;
    layer.skeletons = {{.kind = geometry::SkeletonKind::point, .points = {{0, 0, 0}}}};
    layer.contributions = {{.thickness = 0.1, .stiffness = 10, .radius = 0.22}};
    layer.frame = {0};
    const auto warnings = [&](double inflation, double proportional) {
        NodeRun node("ImplicitLayer");
        node.inputs["layer"] = {Value::of(layer)};
        node.param("inflation").is = inflation;
        node.param("volume.proportional").is = proportional;
        node.run();
        return node.warnings;
    };
    EXPECT_TRUE(warnings(1, 0).empty());
    EXPECT_TRUE(warnings(1.2, 5).empty());
    ASSERT_EQ(warnings(1.2, 0).size(), 1u);
    EXPECT_NE(warnings(1.2, 0)[0].find("volume.proportional is 0"), std::string::npos);
}

TEST(Skin, RefusesABodyIndexOutOfRange)
{
    const Value part = part_of({{0, 0, 0}}, BaseKind::still);
    NodeRun skin("Skin");
    skin.inputs["mesh"] = {Value::of(geometry::icosphere(0.11, 1))};
    skin.inputs["part"] = {part};
    skin.inputs["scene"] = {Value::of(physics::start({*part.as<LayeredPart>()}))};
    skin.param("body").is = std::int64_t{1};
    try {
        skin.run();
        FAIL();
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("there is no body 1: Layered has 1 parts"),
                  std::string::npos)
            << error.what();
    }
}

// Elements of a list parameter with some numbers given by name, others as they are by default.
static graph::ParamValues element(const graph::Param& list,
                                  const std::map<std::string, graph::ParamValue>& given)
{
    graph::ParamValues values;
    for (const graph::Param& p : list.children) {
        const auto found = given.find(p.name);
        values.push_back(found == given.end() ? p.fallback : found->second);
    }
    return values;
}

TEST(Reach, RestartsWhereAHingeLimitBlocksIt)
{
    NodeRun figure("Figure");
    figure.inputs["part"] = {part_of({{0, 0, 0}, {0.5, 0, 0}, {1.5, 0, 0}}, BaseKind::rigid)};
    const auto hinge = [&](std::int64_t a, double x) {
        return element(figure.type.params[0], {{"a", {a}},
                                               {"b", {a + 1}},
                                               {"point", {std::array{x, 0.0, 0.0}}},
                                               {"lowest_degrees", {a == 0 ? -170.0 : 0.0}},
                                               {"highest_degrees", {a == 0 ? 170.0 : 10.0}}});
    };
    figure.param("hinges").is = graph::ParamValues{{hinge(0, 0)}, {hinge(1, 1)}};

    NodeRun reach("Reach");
    reach.inputs["part"] = {figure.run()};
    const auto miss_at = [&](double degrees) {
        const double angle = degrees * std::numbers::pi / 180;
        const std::array target{2 * std::cos(angle), 2 * std::sin(angle), 0.0};
        reach.param("goals").is = graph::ParamValues{
            {element(reach.type.params[0], {{"frame", {std::int64_t{2}}},
                                            {"point", {std::array{2.0, 0.0, 0.0}}},
                                            {"target", {target}}})}};
        const auto outputs = reach.outputs();
        reach.previous = {outputs[0]};
        return *outputs[1].as<double>();
    };
    EXPECT_LT(miss_at(-90), 1e-4);
    EXPECT_LT(miss_at(-168), 1e-4);
    EXPECT_LT(miss_at(165), 1e-4) << "not the short way, past the limit";
    EXPECT_LT(miss_at(160), 1e-4);
    EXPECT_GT(miss_at(180), 0.1) << "out of reach from anywhere";
}

// All frames of a still figure have one origin. The target goes round the first hinge, 0.6 m off,
// by 0.03 m a frame. A figure that started again from the pose as drawn would bend another way.
TEST(Reach, AStillFigureDoesNotJumpWhereItsTargetMovesEvenly)
{
    NodeRun figure("Figure");
    figure.inputs["part"] = {
        part_of({{0, 0, 0}, {0.3, 0, 0}, {0.6, 0, 0}, {0.9, 0, 0}}, BaseKind::still)};
    graph::ParamValues hinges;
    for (std::int64_t a = 0; a < 3; ++a) {
        const std::array at{0.3 * double(a + 1), 0.0, 0.0};
        hinges.push_back({element(figure.type.params[0], {{"a", {a}},
                                                          {"b", {a + 1}},
                                                          {"point", {at}},
                                                          {"axis", {std::array{0.0, 0.0, 1.0}}},
                                                          {"lowest_degrees", {-170.0}},
                                                          {"highest_degrees", {170.0}}})});
    }
    figure.param("hinges").is = hinges;
    NodeRun reach("Reach");
    reach.inputs["part"] = {figure.run()};
    std::vector<Vec3> before;
    for (int frame = 0; frame < 60; ++frame) {
        const double angle = 0.05 * frame;
        const std::array target{0.3 + 0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.0};
        reach.param("goals").is = graph::ParamValues{
            {element(reach.type.params[0], {{"frame", {std::int64_t{3}}},
                                            {"point", {std::array{1.2, 0.0, 0.0}}},
                                            {"target", {target}}})}};
        const auto outputs = reach.outputs();
        reach.previous = {outputs[0]};
        EXPECT_LT(*outputs[1].as<double>(), 1e-3) << frame;
        std::vector<Vec3> joints;
        const auto& frames = outputs[0].as<LayeredPart>()->frames;
        for (std::size_t k = 2; k < 4; ++k) {
            joints.emplace_back(frames[k] * Vec3(0.3 * double(k), 0, 0));
        }
        for (std::size_t k = 0; frame > 0 && k < joints.size(); ++k) {
            EXPECT_LT((joints[k] - before[k]).norm(), 0.1) << frame;
        }
        before = joints;
    }
}

TEST(ImplicitLayer, WarnsOfParticlesThatStartTooClose)
{
    for (const double apart : {0.05, 0.02}) {
        geometry::ImplicitLayer layer;
        for (std::uint32_t i = 0; i < 3; ++i) {
            layer.frame.push_back(i);
            layer.skeletons.push_back({.kind = geometry::SkeletonKind::point,
                                       .points = {{i == 2 ? 3 : apart * i, 0, 0}}});
            layer.contributions.push_back({.thickness = 0.1, .stiffness = 10, .radius = 0.22});
        }
        NodeRun node("ImplicitLayer");
        node.inputs["layer"] = {Value::of(layer)};
        node.param("base").is = "particles";
        node.param("substance.stiffness").is = 5.0;
        node.param("substance.rest_distance").is = 0.05;
        node.run();
        ASSERT_EQ(node.warnings.size(), apart < 0.03 ? 1u : 0u);
        if (!node.warnings.empty()) {
            EXPECT_NE(node.warnings[0].find("particles start 0.02 m apart, but "
                                            "substance.rest_distance is 0.05 m"),
                      std::string::npos)
                << node.warnings[0];
        }
    }
}

TEST(Polygonize, WarnsOfCellsThatAreTooCoarse)
{
    for (const double cell : {0.02, 1.0}) {
        NodeRun node("Polygonize");
        const Value ball = part_of({{0.3, 0.3, 0.3}}, BaseKind::still);
        node.inputs["scene"] = {Value::of(physics::start({*ball.as<LayeredPart>()}))};
        node.param("cell").is = cell;
        node.run();
        ASSERT_EQ(node.warnings.size(), cell < 1 ? 0u : 1u);
        if (cell == 1) {
            EXPECT_NE(node.warnings[0].find("body 0 has 0 triangles"), std::string::npos)
                << node.warnings[0];
        }
    }
}

TEST(Skeletons, WarnsOfAnEmptyLayer)
{
    NodeRun node("Skeletons");
    node.run();
    ASSERT_EQ(node.warnings.size(), 1u);
    EXPECT_EQ(node.warnings[0].find("there are no skeletons"), 0u) << node.warnings[0];
}

TEST(Figure, RefusesALowerLimitAboveTheUpperLimit)
{
    NodeRun figure("Figure");
    figure.inputs["part"] = {part_of({{0, 0, 0}, {0.2, 0, 0}}, BaseKind::rigid)};
    const auto limit = [&](double highest) {
        figure.param("hinges").is =
            graph::ParamValues{{element(figure.type.params[0], {{"b", {std::int64_t{1}}},
                                                                {"lowest_degrees", {50.0}},
                                                                {"highest_degrees", {highest}}})}};
    };
    limit(60);
    EXPECT_NO_THROW(figure.run());
    limit(40);
    EXPECT_THROW(figure.run(), std::invalid_argument);
}

// A universal joint by two hinges on one pair of frames would hold them rigidly.
TEST(Figure, RefusesTwoHingesAboutDifferentAxesOnOnePair)
{
    NodeRun figure("Figure");
    figure.inputs["part"] = {part_of({{0, 0, 0}, {0.2, 0, 0}}, BaseKind::rigid)};
    const auto hinges = [&](const std::array<double, 3>& axis, const std::array<double, 3>& point) {
        const graph::Param& list = figure.type.params[0];
        graph::ParamValues both(2);
        both[0].is = element(list, {{"b", {std::int64_t{1}}}});
        both[1].is =
            element(list, {{"b", {std::int64_t{1}}}, {"axis", {axis}}, {"point", {point}}});
        figure.param("hinges").is = both;
    };
    hinges({0, 0, 2}, {0, 0, 0.1});
    EXPECT_NO_THROW(figure.run());
    hinges({0, 1, 0}, {0, 0, 0});
    EXPECT_THROW(figure.run(), std::invalid_argument);
    hinges({0, 0, 1}, {0.1, 0, 0});
    EXPECT_THROW(figure.run(), std::invalid_argument);
}

TEST(Layered, AStillMeshMayChangeItsShapeFromFrameToFrame)
{
    NodeRun ball("Primitive"), move("Transform"), skeletons("Skeletons"), body("ImplicitLayer"),
        layered("Layered");
    ball.param("shape").is = std::string("sphere");
    move.inputs["mesh"] = {ball.run()};
    std::vector<graph::ParamValue> item;
    for (const auto& type_param : skeletons.type.params) {
        if (type_param.name != "skeletons") continue;
        for (const auto& child : type_param.children) {
            item.push_back(child.fallback);
            if (child.name == "kind") item.back().is = std::string("mesh");
        }
    }
    graph::ParamValue element;
    element.is = item;
    skeletons.param("skeletons").is = std::vector<graph::ParamValue>{element};
    body.param("base").is = std::string("still");
    std::vector<std::size_t> samples;
    for (int frame = 1; frame <= 4; ++frame) {
        move.param("scale").is = std::array<double, 3>{1, 1 + 0.1 * frame, 1};
        skeletons.inputs["mesh"] = {move.run(frame)};
        body.inputs["layer"] = {skeletons.run(frame)};
        layered.inputs["parts"] = {body.run(frame)};
        layered.previous = {layered.run(frame)};
        const auto scene = layered.previous[0].as<LayeredScene>();
        samples.push_back(scene->parts[0].body->samples.count());
        if (frame == 1) continue;
        EXPECT_EQ(scene->states[0].distance.size(), samples.back());
    }
    EXPECT_NE(samples.front(), samples.back()) << "the test is of a number that changes";
}

namespace {

NodeRun render_of_two_pressed_balls()
{
    std::vector<LayeredPart> parts;
    for (const double x : {-0.08, 0.08}) {
        parts.push_back(*part_of({{x, 0, 0}}, BaseKind::still).as<LayeredPart>());
        parts.back().colour = {x < 0 ? 1.0f : 0.0f, 0, x < 0 ? 0.0f : 1.0f};
    }
    NodeRun render("Render");
    render.inputs["layers"] = {Value::of(physics::start(parts))};
    render.param("width").is = std::int64_t{64};
    render.param("height").is = std::int64_t{64};
    render.param("look").is = std::string("plain");
    render.param("camera.azimuth").is = 0.0;
    render.param("camera.elevation").is = 5.0;
    return render;
}

}  // namespace

// Two pressed balls side by side: red on the left, blue on the right, with one border between.
TEST(RenderNode, DrawsLayersWithoutPolygons)
{
    NodeRun render = render_of_two_pressed_balls();
    const auto image = render.run().as<::render::Image>();
    EXPECT_TRUE(render.warnings.empty());
    const auto redness = [&](std::size_t x) {
        const std::size_t at = 4 * (32 * 64 + x);
        return int(image->rgba[at]) - int(image->rgba[at + 2]);
    };
    for (std::size_t x = 20; x < 31; ++x) EXPECT_GT(redness(x), 60) << x;
    for (std::size_t x = 33; x < 44; ++x) EXPECT_LT(redness(x), -60) << x;
}

TEST(RenderNode, ColoursLayersByTheirCompressionAndByNothingElse)
{
    NodeRun render = render_of_two_pressed_balls();
    render.param("colour.by").is = std::string("attribute");
    render.param("colour.attribute").is = std::string("compression");
    EXPECT_FALSE(render.run().as<::render::Image>()->rgba.empty());
    render.param("colour.attribute").is = std::string("speed");
    try {
        render.run();
        FAIL() << "coloured by an attribute that layers do not have";
    } catch (const std::exception& wrong) {
        EXPECT_NE(std::string(wrong.what()).find("they have compression"), std::string::npos)
            << wrong.what();
    }
}

TEST(Layered, WarnsOfBodiesThatBeginBehindAnOpenMesh)
{
    auto floor = std::make_shared<geometry::TriMesh>(geometry::grid(2, 2, 2, 2));
    physics::Collider collider;
    collider.kind = physics::Collider::Kind::mesh;
    collider.mesh = floor;
    collider.tree = std::make_shared<const geometry::TriangleBvh>(*floor);
    const auto warnings = [&](double y, bool sheet, BaseKind kind) {
        collider.sheet = sheet;
        NodeRun layered("Layered");
        layered.inputs["parts"] = {part_of({{0, 0.5, 0}}, kind), part_of({{0, y, 0}}, kind)};
        layered.inputs["colliders"] = {Value::of(collider)};
        layered.run();
        return layered.warnings;
    };
    EXPECT_TRUE(warnings(0.5, true, BaseKind::rigid).empty());
    ASSERT_EQ(warnings(-0.5, true, BaseKind::rigid).size(), 1u);
    EXPECT_EQ(warnings(-0.5, true, BaseKind::rigid)[0].find("body 1 begins behind collider 0"), 0u);
    EXPECT_TRUE(warnings(-0.5, true, BaseKind::still).empty()) << "nothing pushes it";
    EXPECT_TRUE(warnings(-0.5, false, BaseKind::rigid).empty()) << "in a solid, as may be meant";
}
