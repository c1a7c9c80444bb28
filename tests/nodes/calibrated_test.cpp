// Voxelize with stiffness = calibrated: thin and tilted models in cubes as large as they are thick,
// through nodes.

#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3;

constexpr double young = 1e9, density = 1000, length = 0.5, width = 0.04, thick = 0.02;

TriMesh turned_strip()
{
    TriMesh mesh = geometry::box({length, width, thick}, {25, 2, 1});
    geometry::move(mesh, geometry::placement({0, 0, 0}, {20, 20, 20}, {1, 1, 1}, {0, 0, 0}));
    return mesh;
}

NodeRun voxelize(const TriMesh& mesh, double size, const std::string& stiffness)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.param("method").is = std::string("solid");
    node.param("size").is = size;
    node.param("stiffness").is = stiffness;
    node.param("matter.young").is = young;
    node.param("matter.density").is = density;
    return node;
}

double lowest_frequency(const TriMesh& mesh, const graph::Value& cubes)
{
    NodeRun node("Modes");
    node.inputs["mesh"] = {graph::Value::of(TriMesh(mesh))};
    node.inputs["cubes"] = {cubes};
    node.param("count").is = std::int64_t{1};
    return *node.outputs().at(1).as<double>();
}

TEST(CalibratedCubes, ATiltedStripVibratesAsTheTheoryOfBeamsHasIt)
{
    // Free ends: f = (beta L)^2 / (2 pi L^2) sqrt(E I / (rho A)), I / A = t^2 / 12; shear and the
    // inertia of turning take about 1 % at L = 25 t.
    const double beam = std::pow(4.730041, 2) / (2 * std::numbers::pi * length * length) *
                        std::sqrt(young * thick * thick / (12 * density));
    const TriMesh mesh = turned_strip();
    NodeRun filled = voxelize(mesh, 2 * thick, "filled"),
            own = voxelize(mesh, 2 * thick, "calibrated");
    EXPECT_GT(lowest_frequency(mesh, filled.run()) / beam, 1.8);
    EXPECT_EQ(filled.warnings.size(), 1u);
    EXPECT_NEAR(lowest_frequency(mesh, own.run()) / beam, 1, 0.06);
    EXPECT_EQ(own.warnings, std::vector<std::string>{});
}

TEST(CalibratedCubes, ThinnerWallsAreTold)
{
    NodeRun node = voxelize(turned_strip(), 3 * thick, "calibrated");
    node.param("calibration.fine").is = std::int64_t{3};
    node.run();
    ASSERT_EQ(node.warnings.size(), 1u);
    EXPECT_EQ(node.warnings[0].rfind("the model is 0.33 cubes thick (0.02 m, at (", 0), 0u)
        << node.warnings[0];
    EXPECT_NE(
        node.warnings[0].find("): its calibrated stiffness may be wrong by a factor of 2; use "
                              "cubes of 0.04 m"),
        std::string::npos);
}

TEST(CalibratedCubes, TooManyFineCubesAreRefused)
{
    NodeRun node = voxelize(turned_strip(), thick / 2, "calibrated");
    node.param("calibration.fine").is = std::int64_t{32};
    try {
        node.run();
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("the limit is 400000: lower calibration.fine"),
                  std::string::npos)
            << e.what();
    }
}

// How far the end of the strip sags, held by its other end. m.
double sag(double cubes, const std::string& stiffness)
{
    fixtures::Scene scene(fmt::format(
        R"(
"straight": {{ "type": "Primitive@1", "params": {{ "shape": "box", "box":
    {{ "size": [{}, {}, {}], "divisions_x": 25, "divisions_y": 2, "divisions_z": 1 }} }} }},
"strip": {{ "type": "Transform@1", "inputs": {{ "mesh": "straight.mesh" }}, "params":
    {{ "rotate_degrees": [20, 20, 20] }} }},
"cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "strip.mesh" }}, "params":
    {{ "method": "solid", "size": {}, "stiffness": "{}", "matter":
        {{ "young": {}, "density": {}, "poisson": 0.3 }} }} }},
"hold": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params":
    {{ "where": "sphere", "sphere": {{ "centre": [-0.23, -0.075, 0.085], "radius": 0.06 }} }} }},
"sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes", "pins": ["hold.pins"] }},
    "params": {{ "initial_shape": "equilibrium", "gravity": [0, 0, -0.981] }} }},
"shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "strip.mesh", "cubes": "cubes.cubes",
    "state": "sim.state" }} }},
"sag": {{ "type": "Measure@1", "inputs": {{ "mesh": "shape.mesh", "rest": "strip.mesh" }},
    "params": {{ "what": "displacement_max" }} }})",
        length, width, thick, cubes * thick, stiffness, young, density));
    return *scene.at<double>("sag");
}

TEST(CalibratedCubes, ATiltedStripSagsAsOneOfSmallCubesDoes)
{
    // A pin holds the corners that it reaches: in large cubes the clamp is shorter by half a cube.
    const double fine = sag(0.25, "filled");
    EXPECT_GT(fine, 1e-4);
    EXPECT_LT(sag(2, "filled") / fine, 0.3);
    EXPECT_NEAR(sag(2, "calibrated") / fine, 1, 0.2);
}

// Two strips side by side, half a cube of two thicknesses apart.
TriMesh two_strips()
{
    TriMesh upper = turned_strip();
    const TriMesh lower = turned_strip();
    const auto turn = geometry::placement({0, 0, 0}, {20, 20, 20}, {1, 1, 1}, {0, 0, 0});
    const Vec3 up = turn.linear() * Vec3(0, 0, 2 * thick);
    geometry::move(upper, geometry::placement(up, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}));
    const std::array<const TriMesh*, 2> both{&lower, &upper};
    return geometry::merge(both);
}

TEST(CalibratedCubes, StripsHalfACubeApartVibrateAsOneAloneWherePiecesAreApart)
{
    const double alone =
        lowest_frequency(turned_strip(), voxelize(turned_strip(), 2 * thick, "calibrated").run());
    const TriMesh mesh = two_strips();
    NodeRun apart = voxelize(mesh, 2 * thick, "calibrated"),
            merged = voxelize(mesh, 2 * thick, "calibrated");
    apart.param("pieces").is = std::string("apart");
    EXPECT_NEAR(lowest_frequency(mesh, apart.run()), alone, 0.05 * alone);
    EXPECT_GT(lowest_frequency(mesh, merged.run()), 1.3 * alone);
}

TEST(CalibratedCubes, ThinPiecesThatAreApartAreTold)
{
    NodeRun node = voxelize(two_strips(), 2 * thick, "filled");
    node.param("pieces").is = std::string("apart");
    node.run();
    ASSERT_EQ(node.warnings.size(), 1u);
    EXPECT_NE(node.warnings[0].find("is 0.5 cubes thick"), std::string::npos) << node.warnings[0];
    EXPECT_NE(node.warnings[0].find("times too stiff in bending"), std::string::npos);
}

TEST(CalibratedCubes, WhatCannotBeCalibratedIsToldBefore)
{
    const auto problems = [](const std::string& params) {
        std::string all;
        const auto loaded = graph::load_text(
            R"({ "aspic": 1, "frames": { "first": 1, "last": 2, "fps": 24 }, "nodes": {
"box": { "type": "Primitive@1", "params": { "shape": "box" } },
"cubes": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": { "method": "solid",
    "stiffness": "calibrated", )" +
                params + "} } } }",
            "scene.json", nodes::registry());
        for (const auto& problem : loaded.problems) all += problem.message;
        return all;
    };
    EXPECT_EQ(problems(R"("size": 0.1)"), "");
    EXPECT_NE(problems(R"("thickness": 0.1)").find("set thickness = 0, or stiffness = filled"),
              std::string::npos);
    EXPECT_NE(problems(R"("quality": "good")").find("set quality = by_size"), std::string::npos);
    EXPECT_EQ(problems(R"("pieces": "apart")"), "");
}

TEST(CalibratedCubes, FiniteDifferencesSayThatTheyLumpTheMass)
{
    NodeRun node = voxelize(turned_strip(), thick, "calibrated");
    const graph::Value cubes = node.run();
    const auto warnings = [&](const char* element) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {cubes};
        simulate.param("bricks.element").is = std::string(element);
        simulate.previous = {simulate.run()};
        simulate.run();
        return simulate.warnings;
    };
    EXPECT_TRUE(warnings("incompatible").empty());
    ASSERT_EQ(warnings("one_point").size(), 1u);
    EXPECT_NE(warnings("one_point")[0].find("lumps their mass"), std::string::npos);
}

}  // namespace
