// Several models of cubes in one Simulate, and their parts of its state.

#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <array>

namespace {

using fixtures::NodeRun;
using graph::Value;

Value block(int n, double h, const geometry::Vec3& origin)
{
    geometry::Cubes cubes = fixtures::box(n, n, n, h, {.young = 1e6, .stiffness_damping = 0.01});
    cubes.origin = origin;
    return Value::of(std::move(cubes));
}

// A coarse block, and a fine one above it.
struct TwoBlocks {
    Value low = block(2, 0.1, geometry::Vec3::Zero());
    Value high = block(4, 0.04, geometry::Vec3(0.02, 0.25, 0.02));

    NodeRun simulate() const
    {
        NodeRun out("Simulate");
        out.inputs["cubes"] = {low, high};
        return out;
    }
};

std::string told(const auto& run)
{
    try {
        run();
        return "";
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
}

TEST(SeveralBodies, EachNodeTakesThePartOfItsCubes)
{
    const TwoBlocks two;
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {two.high};
    pin.param("where").is = std::string("ends");
    NodeRun simulate = two.simulate();
    simulate.inputs["pins"] = {pin.run()};
    Value state = simulate.run();
    for (int frame = 2; frame < 6; ++frame) {
        simulate.previous = {state};
        state = simulate.run(frame);
    }
    EXPECT_TRUE(simulate.warnings.empty()) << simulate.warnings[0];
    const auto mesh_of = [&](const Value& cubes) {
        NodeRun mesh("CubeMesh");
        mesh.inputs["cubes"] = {cubes};
        mesh.inputs["state"] = {state};
        return mesh.run().as<geometry::TriMesh>();
    };
    // The pins hold the high block; the low one falls for 4 frames: 16 g / 24^2 / 2.
    const auto high = mesh_of(two.high), low = mesh_of(two.low);
    ASSERT_EQ(high->positions.size(), 125u);
    ASSERT_EQ(low->positions.size(), 27u);
    EXPECT_NEAR(high->positions[0].y(), 0.25f, 1e-3f);
    EXPECT_NEAR(low->positions[0].y(), -8 * 9.81 / 576, 1e-6);

    // Measure: 8 kg at 4 g / 24, and a block that is held.
    const auto energy_of = [&](const Value& cubes) {
        NodeRun measure("Measure");
        measure.inputs["cubes"] = {cubes};
        measure.inputs["state"] = {state};
        measure.param("what").is = std::string("kinetic_energy");
        return *measure.run().as<double>();
    };
    const double speed = 4 * 9.81 / 24;
    EXPECT_NEAR(energy_of(two.low), 0.5 * 8 * speed * speed, 0.01);
    EXPECT_LT(energy_of(two.high), 1e-2);

    // A mesh in the high block follows it alone.
    NodeRun embed("Embed");
    embed.inputs["cubes"] = {two.high};
    embed.inputs["state"] = {state};
    embed.inputs["mesh"].push_back(Value::of(geometry::TriMesh(*mesh_of(two.high))));
    EXPECT_EQ(embed.run().as<geometry::TriMesh>()->positions.size(), 125u);
    embed.inputs["cubes"] = {block(2, 0.2, geometry::Vec3::Zero())};
    EXPECT_EQ(told([&] { embed.run(); }).find("the state is of 2 bodies, and none has these cubes"),
              0u);
}

TEST(SeveralBodies, EachStartsWithItsOwnVelocityAndSpin)
{
    const TwoBlocks two;
    NodeRun simulate = two.simulate();
    graph::ParamValues still, thrown;
    for (const auto& p : simulate.type.params) {
        if (p.name != "bodies") continue;
        for (const auto& child : p.children) {
            still.push_back(child.fallback);
            thrown.push_back(child.fallback);
        }
    }
    thrown[0].is = std::array<double, 3>{1, 0, 0};
    thrown[1].is = std::array<double, 3>{0, 0, 180 / std::numbers::pi};
    const auto rows = [](const graph::ParamValues& values) {
        graph::ParamValue out;
        out.is = values;
        return out;
    };
    simulate.param("bodies").is = graph::ParamValues{rows(still), rows(thrown)};
    simulate.param("initial_velocity").is = std::array<double, 3>{0, 2, 0};
    const auto state = simulate.run().as<physics::State>();
    ASSERT_EQ(state->v.size(), 152u);
    EXPECT_TRUE(state->v[0].isApprox(geometry::Vec3(0, 2, 0)));
    // 1 rad/s about z through the centre at (0.1, 0.33, 0.1).
    for (std::size_t k = 27; k < state->v.size(); ++k) {
        const auto& p = state->x[k];
        EXPECT_TRUE(state->v[k].isApprox(geometry::Vec3(1.33 - p.y(), 1.9 + p.x(), 0), 1e-9));
    }
    simulate.param("bodies").is = graph::ParamValues{rows(still), rows(still), rows(still)};
    EXPECT_EQ(told([&] { simulate.run(); }).find("`bodies` has 3 entries for 2 links"), 0u);
}

TEST(SeveralBodies, WhatDoesNotFitIsTold)
{
    const TwoBlocks two;
    NodeRun simulate = two.simulate();
    simulate.inputs["cubes"] = {two.low, two.low};
    EXPECT_EQ(told([&] { simulate.run(); }).find("cubes 1 and 2 of 2 are the same"), 0u);
    NodeRun lattice = two.simulate();
    lattice.param("method").is = std::string("lattice");
    EXPECT_EQ(told([&] { lattice.run(); }).find("method lattice moves one model of cubes"), 0u);
    NodeRun skinned = two.simulate(), ball("Primitive");
    skinned.inputs["surface"] = {ball.run()};
    EXPECT_EQ(told([&] { skinned.run(); }).find("`surface` has 1 links, expected 2"), 0u);
    NodeRun pin("Pin"), pinned = two.simulate();
    pin.inputs["cubes"] = {block(2, 0.2, geometry::Vec3::Zero())};
    pin.param("box.size").is = std::array<double, 3>{9, 9, 9};
    pinned.inputs["pins"] = {pin.run()};
    EXPECT_EQ(told([&] { pinned.run(); }).find("pins of corners of other cubes"), 0u);
    // The same bodies in another order.
    const Value state = two.simulate().run();
    NodeRun turned = two.simulate();
    turned.inputs["cubes"] = {two.high, two.low};
    turned.inputs["start"] = {state};
    EXPECT_EQ(told([&] { turned.run(); }).find("start state: it is of other bodies"), 0u);
    NodeRun none = two.simulate();
    none.inputs["cubes"].clear();
    EXPECT_EQ(told([&] { none.run(); }).find("expected a link to cubes"), 0u);
}

TEST(SeveralBodies, ASheetBesideASolidMovesByBricksAlone)
{
    const Value sheet = NodeRun("Plane").run();
    for (const char* method : {"bricks", "springs", "lattice", "shell"}) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {block(2, 0.1, geometry::Vec3(0, 5, 0)), sheet};
        simulate.param("method").is = std::string(method);
        if (std::string(method) == "bricks") {
            EXPECT_NO_THROW(simulate.run());
            continue;
        }
        const std::string text = told([&] { simulate.run(); });
        EXPECT_EQ(text.rfind("sheets without thickness (cubes[1]) and solids (cubes[0])", 0), 0u)
            << text;
        EXPECT_NE(text.find("set method = bricks"), text.npos) << text;
    }
}

TEST(SeveralBodies, EnergyAndStressAreThoseOfASolidAlone)
{
    const Value sheet = NodeRun("Plane").run(), solid = block(2, 0.1, geometry::Vec3(0, 5, 0));
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {solid, sheet};
    simulate.previous = {simulate.run(1)};
    const Value state = simulate.run(2);
    for (const char* what : {"elastic_energy", "stress_max"}) {
        NodeRun measure("Measure");
        measure.inputs["state"] = {state};
        measure.param("what").is = std::string(what);
        const auto refusal = [&] { return told([&] { measure.run(); }); };
        EXPECT_NE(refusal().find("Link `cubes` of a solid"), std::string::npos) << refusal();
        measure.inputs["cubes"] = {sheet};
        EXPECT_NE(refusal().find("Link `cubes` of a solid"), std::string::npos) << refusal();
        measure.inputs["cubes"] = {solid};
        EXPECT_GE(*measure.run().as<double>(), 0);
    }
}

TEST(SeveralBodies, ASurfaceApartFromItsCubesIsRefused)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {block(2, 0.1, geometry::Vec3::Zero())};
    NodeRun far("Primitive");
    far.param("centre").is = std::array<double, 3>{0, 9, 0};
    simulate.inputs["surface"] = {far.run()};
    const std::string text = told([&] { simulate.run(); });
    EXPECT_EQ(text.rfind("surface[0] lies apart from cubes[0]", 0), 0u) << text;
}

TEST(SeveralBodies, AGiantIsAskedForItsUnit)
{
    for (const double size : {60.0, 40.0}) {
        NodeRun simulate("Simulate");
        simulate.inputs["cubes"] = {block(2, size / 2, geometry::Vec3::Zero())};
        simulate.run();
        // 9.81 m/s^2 / (2 * 24^2 / s^2) = 8.5 mm.
        const bool told = !simulate.warnings.empty() &&
                          simulate.warnings[0].find("cubes[0] is 60 m long, and falls 0.0085 m") !=
                              std::string::npos;
        EXPECT_EQ(told, size > 50);
    }
}

}  // namespace
