#include "geometry/cubes/plane.hpp"
#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/nodes/scene.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace {

using fixtures::NodeRun;
using graph::Value;

// Pins at the low end of a beam.
Value pinned_below(const Value& cubes)
{
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {cubes};
    pin.param("where").is = std::string("ends");
    pin.param("ends.end").is = std::string("low");
    return pin.run();
}

TEST(Simulate, ABeamPinnedAtOneEndSagsAfterTheFirstFrame)
{
    const Value cubes = Value::of(fixtures::box(6, 1, 1, 0.1, {.young = 1e5}));
    for (const char* method : {"bricks", "springs", "lattice"}) {
        const Value pins = pinned_below(cubes);
        EXPECT_EQ(pins.as<physics::Pins>()->corner.size(), 8u);  // two planes of four corners

        NodeRun simulate("Simulate");
        simulate.param("method").is = std::string(method);
        // Regions narrow enough for a beam and enough steps to be as stiff as the material, so that
        // nothing is warned of.
        simulate.param("lattice.half_width").is = std::int64_t{1};
        simulate.param("lattice.calibrate").is = std::string("stretch");
        simulate.param("step.substeps").is = std::int64_t{8};
        simulate.inputs["cubes"] = {cubes};
        simulate.inputs["pins"] = {pins};
        simulate.inputs["colliders"] = {NodeRun("Ground").run()};
        simulate.inputs["forces"] = {NodeRun("Force").run()};
        Value state = simulate.run();
        const auto rest = geometry::corner_positions(*cubes.as<geometry::Cubes>());
        EXPECT_EQ(state.as<physics::State>()->x, rest);
        simulate.previous = {state};
        state = simulate.run();
        const auto moved = state.as<physics::State>();
        EXPECT_EQ(moved->x[0], rest[0]);
        EXPECT_LT(moved->x.back().y(), rest.back().y());
        EXPECT_DOUBLE_EQ(moved->time, 1.0 / 24);
        EXPECT_TRUE(simulate.warnings.empty());
    }
}

// How far the end of a bar of 1 m x 0.1 m x 0.1 m along `axis` that is held at its other end moves
// along y under `gravity`, by a lattice of cubes of 0.1 m with its defaults. E = 1 MPa.
double moved_end(const std::string& axis, const std::string& held, double gravity)
{
    const std::string size = axis == "x" ? "[1, 0.1, 0.1]" : "[0.1, 1, 0.1]";
    fixtures::Scene scene(fmt::format(R"(
        "bar": {{ "type": "Primitive@1", "params": {{ "box": {{ "size": {} }} }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "bar.mesh" }},
                   "params": {{ "method": "solid", "size": 0.1, "matter": {{ "density": 1000,
                       "young": 1e6, "poisson": 0.3, "mass_damping": 8 }} }} }},
        "wall": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                  "params": {{ "where": "ends",
                      "ends": {{ "axis": "{}", "end": "{}", "layers": 0 }} }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                 "pins": ["wall.pins"] }}, "params": {{ "method": "lattice",
                 "gravity": [0, {}, 0], "dt": 0.5, "step": {{ "substeps": 0 }} }} }})",
                                      size, axis, held, gravity));
    const auto cubes = scene.at<geometry::Cubes>("cubes");
    const auto state = scene.at<physics::State>("sim", 17);  // at rest
    const auto rest = geometry::corner_positions(*cubes);
    double most = 0;
    for (std::size_t k = 0; k < rest.size(); ++k) {
        most = std::max(most, std::abs(state->x[k].y() - rest[k].y()));
    }
    return most;
}

// The defaults bend and stretch a bar one cube thick as its material does, as far as regions of
// half width 2 can: within a third. Calibrated for a bend alone it hangs five times too far, and
// for stretch alone it sags a quarter as far.
TEST(Simulate, AThinBarByALatticeStretchesAndBendsAsItsMaterial)
{
    // rho g L^2 / (2 E), and q L^4 / (8 E I) = 12 rho g L^4 / (8 E t^2) with 1 % of shear.
    EXPECT_NEAR(moved_end("y", "high", -2) / 1e-3, 1, 0.33);
    EXPECT_NEAR(moved_end("x", "low", -0.2) / 0.0303, 1, 0.33);
}

TEST(Simulate, WhatStartsFromAnotherKnowsWhatMayYield)
{
    const Value cubes = Value::of(fixtures::box(3, 1, 1, 0.1, {.young = 1e5}));
    NodeRun first("Simulate"), yields("Simulate"), springs("Simulate");
    first.inputs["cubes"] = yields.inputs["cubes"] = springs.inputs["cubes"] = {cubes};
    yields.inputs["start"] = {first.run()};
    yields.param("bricks.plastic.yield").is = 0.01;
    const Value none = yields.run();
    EXPECT_EQ(none.as<physics::State>()->plastic_strain, std::vector<float>(3, 0.0f));
    // Nothing has flowed, and springs let nothing flow.
    springs.inputs["start"] = {none};
    springs.param("method").is = "springs";
    EXPECT_TRUE(springs.run().as<physics::State>()->plastic_strain.empty());
}

// How far the end of a cantilever is below its rest 3 s after it has hung for one.
double sag_left(const Value& cubes, const std::string& method, double yield)
{
    const Value pins = pinned_below(cubes);
    NodeRun simulate("Simulate");
    simulate.param("method").is = method;
    simulate.param("step.substeps").is = std::int64_t{4};
    simulate.param(method + ".plastic.yield").is = yield;
    simulate.param(method + ".plastic.flow").is = 1e6;
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pins};
    Value state = simulate.run();
    for (int frame = 0; frame < 96; ++frame) {
        if (frame == 24) simulate.param("gravity").is = std::array<double, 3>{};
        simulate.previous = {state};
        state = simulate.run();
    }
    const auto end = state.as<physics::State>();
    return cubes.as<geometry::Cubes>()->corner_position(end->x.size() - 1).y() - end->x.back().y();
}

TEST(Simulate, ABeamThatYieldsStaysBent)
{
    constexpr fixtures::Stuff soft{.young = 2e5, .mass_damping = 4, .stiffness_damping = 0.01};
    const Value cubes = Value::of(fixtures::box(6, 2, 2, 0.1, soft));
    for (const char* method : {"bricks", "lattice"}) {
        EXPECT_LT(std::abs(sag_left(cubes, method, 0)), 0.01) << method;
        EXPECT_GT(sag_left(cubes, method, 0.003), 0.03) << method;
    }
    const geometry::Matter card{"card", 1000, 2e6, 0.3, 4, 0.01};
    const Value plane = Value::of(
        geometry::plane_cubes(geometry::rectangle_cells(8, 2), {1, 0.1, {0, 0, 0}}, 0.05, card));
    EXPECT_LT(std::abs(sag_left(plane, "shell", 0)), 0.01);
    EXPECT_GT(sag_left(plane, "shell", 0.003), 0.05);
}

TEST(Simulate, WhatYieldedIsMeasuredAndCarriedToAMesh)
{
    constexpr fixtures::Stuff soft{.young = 2e5, .mass_damping = 4, .stiffness_damping = 0.01};
    const Value cubes = Value::of(fixtures::box(6, 2, 2, 0.1, soft));
    NodeRun simulate("Simulate"), measure("Measure"), shape("CubeMesh"), embed("Embed");
    simulate.param("bricks.plastic.yield").is = 0.003;
    simulate.param("step.substeps").is = std::int64_t{4};
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pinned_below(cubes)};
    measure.param("what").is = "plastic_strain_max";
    Value state = simulate.run();
    measure.inputs["state"] = {state};
    EXPECT_EQ(*measure.run().as<double>(), 0);
    for (int frame = 0; frame < 12; ++frame) {
        simulate.previous = {state};
        state = simulate.run();
    }
    measure.inputs["state"] = {state};
    const double most = *measure.run().as<double>();
    EXPECT_GT(most, 0.01);
    shape.inputs["cubes"] = {cubes};
    embed.inputs["mesh"] = {shape.run()};
    embed.inputs["cubes"] = {cubes};
    embed.inputs["state"] = {state};
    const auto mesh = embed.run().as<geometry::TriMesh>();
    const auto found = std::find_if(mesh->attributes.begin(), mesh->attributes.end(),
                                    [](const auto& a) { return a.name == "plastic_strain"; });
    ASSERT_NE(found, mesh->attributes.end());
    const auto carried = double(*std::max_element(found->values.begin(), found->values.end()));
    EXPECT_LE(carried, most * (1 + 1e-6));
    EXPECT_GT(carried, 0.5 * most);
}

// The state of a node that goes on from `start` by another method, or by the same, after a frame.
Value gone_on(const Value& cubes, const Value& start, const std::string& method, NodeRun& node)
{
    node.param("method").is = method;
    node.inputs["cubes"] = {cubes};
    node.inputs["start"] = {start};
    node.previous = {node.run()};
    return node.run();
}

TEST(Simulate, RestShapesThatAMethodDoesNotKeepAreToldOf)
{
    const Value cubes = Value::of(fixtures::box(3, 1, 1, 0.1, {.young = 1e5}));
    physics::State dented;
    dented.x = geometry::corner_positions(*cubes.as<geometry::Cubes>());
    dented.v.resize(dented.x.size(), geometry::Vec3::Zero());
    dented.plastic.assign(18 * 3, 0.01f);
    dented.plastic_of = physics::PlasticOf::bricks;
    dented.plastic_strain = {0.01f, 0.02f, 0.03f};
    const Value start = Value::of(dented);
    NodeRun bricks("Simulate");
    const Value kept = gone_on(cubes, start, "bricks", bricks);
    EXPECT_EQ(kept.as<physics::State>()->plastic, dented.plastic);
    EXPECT_TRUE(bricks.warnings.empty());
    for (const char* method : {"springs", "lattice"}) {
        NodeRun other("Simulate");
        const Value lost = gone_on(cubes, start, method, other);
        EXPECT_TRUE(lost.as<physics::State>()->plastic.empty()) << method;
        EXPECT_TRUE(lost.as<physics::State>()->plastic_strain.empty()) << method;
        const auto told = [](const std::string& w) {
            return w.find("changed by for good is lost") != std::string::npos;
        };
        EXPECT_EQ(std::count_if(other.warnings.begin(), other.warnings.end(), told), 1) << method;
    }
    // A plane that was stepped as triangles, and is not any more.
    const Value plane = Value::of(
        geometry::plane_cubes(geometry::rectangle_cells(2, 1), {1, 0.1, {0, 0, 0}}, 0.01));
    dented.x = geometry::corner_positions(*plane.as<geometry::Cubes>());
    dented.v.assign(dented.x.size(), geometry::Vec3::Zero());
    dented.plastic.assign(6 * 4, 0.01f);
    dented.plastic_of = physics::PlasticOf::triangles;
    NodeRun shell("Simulate");
    EXPECT_TRUE(
        gone_on(plane, Value::of(dented), "shell", shell).as<physics::State>()->plastic.empty());
    ASSERT_FALSE(shell.warnings.empty());
    EXPECT_NE(shell.warnings[0].find("plastic.yield is above 0"), std::string::npos);
}

TEST(Simulate, ABeamOneCubeThickSagsTheSameByFiniteDifferences)
{
    const Value cubes = Value::of(fixtures::box(16, 1, 1, 0.1, {.young = 1e7}));
    const auto sag = [&](const char* element, bool of_bricks) {
        NodeRun simulate("Simulate");
        simulate.param("initial_shape").is = std::string("equilibrium");
        simulate.param("bricks.element").is = std::string(element);
        simulate.inputs["cubes"] = {cubes};
        simulate.inputs["pins"] = {pinned_below(cubes)};
        const Value state = simulate.run();
        EXPECT_EQ(state.as<physics::State>()->brick_mass, of_bricks) << element;
        return -state.as<physics::State>()->x.back().y();
    };
    const double expected = sag("incompatible", true);
    EXPECT_NEAR(sag("one_point", false), expected, 0.01 * expected);
    EXPECT_LT(sag("trilinear", true), 0.75 * expected);
}

TEST(Simulate, ABeamThatStartsInEquilibriumHangsInTheFirstFrameAndStays)
{
    const Value cubes = Value::of(fixtures::box(10, 2, 2, 0.1, {.young = 1e6}));
    NodeRun simulate("Simulate");
    simulate.param("initial_shape").is = std::string("equilibrium");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pinned_below(cubes)};
    const double rest = geometry::corner_positions(*cubes.as<geometry::Cubes>()).back().y();
    Value state = simulate.run();
    EXPECT_EQ(state.as<physics::State>()->time, 0);
    const double sag = rest - state.as<physics::State>()->x.back().y();
    EXPECT_GT(sag, 0.1);
    for (int i = 0; i < 20; ++i) {
        simulate.previous = {state};
        state = simulate.run();
        EXPECT_NEAR(rest - state.as<physics::State>()->x.back().y(), sag, 0.01 * sag);
    }
    EXPECT_TRUE(simulate.warnings.empty());
}

TEST(Simulate, RefusesAnEquilibriumWithoutPinsAndSaysWhatToDo)
{
    NodeRun simulate("Simulate");
    simulate.param("initial_shape").is = std::string("equilibrium");
    simulate.inputs["cubes"] = {Value::of(fixtures::box(2, 1, 1, 1))};
    try {
        simulate.run();
        FAIL();
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("link a ground"), std::string::npos)
            << error.what();
    }
}

TEST(Simulate, RefusesCubesThatChangeBetweenFrames)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {Value::of(fixtures::box(2, 1, 1, 1))};
    simulate.previous = {simulate.run()};
    simulate.inputs["cubes"] = {Value::of(fixtures::box(3, 1, 1, 1))};
    try {
        simulate.run(2);
        FAIL();
    } catch (const std::invalid_argument& error) {
        EXPECT_EQ(
            std::string(error.what()).find("the number of cube corners changed from 12 to 16"), 0u)
            << error.what();
    }
}

TEST(Simulate, StartsWithTheGivenVelocityAndSpin)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 1));
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.param("initial_velocity").is = std::array<double, 3>{1, 2, 3};
    simulate.param("initial_spin_degrees").is = std::array<double, 3>{0, 0, 180 / std::numbers::pi};
    const auto state = simulate.run().as<physics::State>();
    // 1 rad/s about z through the centre (1, 1, 1): v = (1, 2, 3) + (1 - y, x - 1, 0).
    for (std::size_t k = 0; k < state->x.size(); ++k) {
        const auto& p = state->x[k];
        EXPECT_TRUE(state->v[k].isApprox(geometry::Vec3(2 - p.y(), 1 + p.x(), 3), 1e-12));
    }
}

TEST(Pin, WarnsOfAnEmptyRegionAndRefusesAMissingMesh)
{
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {Value::of(fixtures::box(1, 1, 1, 0.1))};
    pin.param("box.centre").is = std::array<double, 3>{9, 9, 9};
    EXPECT_TRUE(pin.run().as<physics::Pins>()->corner.empty());
    EXPECT_EQ(pin.warnings.size(), 1u);
    pin.param("where").is = std::string("material");
    EXPECT_THROW(pin.run(), std::invalid_argument);
}

TEST(Collider, KeepsItsPoseOfThePreviousFrame)
{
    NodeRun collider("Collider");
    const Value first = collider.run();
    collider.previous = {first};
    collider.param("translate").is = std::array<double, 3>{0, 1, 0};
    const auto second = collider.run().as<physics::Collider>();
    EXPECT_EQ(second->before.translation().y(), 0);
    EXPECT_EQ(second->pose.translation().y(), 1);
}

TEST(Collider, RefusesASizeOfZeroOnLoading)
{
    const auto problems = [](const std::string& params) {
        return graph::load_text(R"({ "aspic": 1, "nodes": { "hard": { "type": "Collider@1",
            "params": )" + params + " } } }",
                                "c.json", nodes::registry())
            .problems;
    };
    for (const char* empty : {R"({ "kind": "sphere", "sphere": { "radius": 0 } })",
                              R"({ "kind": "box", "box": { "size": [1, 0, 1] } })"}) {
        const auto found = problems(empty);
        ASSERT_EQ(found.size(), 1u) << empty;
        EXPECT_NE(graph::describe(found[0]).find("from 1e-09 to"), std::string::npos)
            << graph::describe(found[0]);
    }
    EXPECT_TRUE(problems(R"({ "kind": "box", "box": { "size": [1, 1e-3, 1] } })").empty());
}

// A picture coloured by stress begins with the first frame.
TEST(Simulate, AtRestTheStressOfBricksIsKnownToBeZero)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {Value::of(fixtures::box(2, 1, 1, 0.1))};
    const Value out = simulate.run();
    const auto& state = *out.as<physics::State>();
    EXPECT_EQ(state.stress, std::vector<float>(2, 0.0f));
    EXPECT_EQ(state.energy, std::vector<float>(2, 0.0f));
}

TEST(Simulate, TakesEveryIntegratorWithAnyNumberOfSteps)
{
    const auto problem = [](const std::string& step) {
        const auto loaded = graph::load_text(
            R"({ "aspic": 1, "nodes": {
                "box": { "type": "Primitive@1" },
                "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" },
                           "params": { "method": "solid" } },
                "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" },
                         "params": { )" +
                step + " } } } }",
            "scene.json", nodes::registry());
        return loaded.problems.empty() ? std::string() : loaded.problems[0].message;
    };
    EXPECT_EQ(problem(R"("step": { "integrator": "sdirk2", "substeps": 0 })"), "");
    EXPECT_EQ(problem(R"("step": { "integrator": "sdirk2" })"), "");
    EXPECT_EQ(problem(R"("step": { "integrator": "sdirk2", "substeps": 2 })"), "");
}

}  // namespace
