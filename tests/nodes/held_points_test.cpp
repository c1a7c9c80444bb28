// Pin with hold = points, through the nodes.

#include "tests/nodes/one_node.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using fixtures::NodeRun;
using geometry::Vec3;
using graph::Value;
using Vector = std::array<double, 3>;

constexpr double h = 0.05;

geometry::Cubes beam()
{
    return fixtures::box(24, 1, 1, h, {.young = 1e9, .poisson = 0.3});
}

// The material up to x, in a box no wider than the beam.
NodeRun pin_up_to(const Value& cubes, double x, const std::string& hold = "points")
{
    NodeRun pin("Pin");
    pin.inputs["cubes"] = {cubes};
    pin.param("hold").is = hold;
    pin.param("box.centre").is = Vector{x / 2, h / 2, h / 2};
    pin.param("box.size").is = Vector{x, h, h};
    return pin;
}

std::shared_ptr<const physics::State> settled(const Value& cubes, NodeRun& pin)
{
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pin.run()};
    simulate.param("initial_shape").is = std::string("equilibrium");
    return simulate.run().as<physics::State>();
}

TEST(HeldPoints, ACantileverSagsByItsFreeLengthWhereCornersLeaveItTooLong)
{
    // w L^4 / (8 E I) + 1.2 w L^2 / (2 G A), free from 2.75 cubes on. Corners hold it up to 2
    // cubes: (22 / 21.25)^4 = 1.15 times as far.
    const geometry::Cubes model = beam();
    const Value cubes = Value::of(model);
    const double free = (24 - 2.75) * h, w = 1000 * 9.81;
    const double expected =
        w * std::pow(free, 4) * 12 / (8 * 1e9 * h * h) + 1.2 * w * free * free / (2 * 1e9 / 2.6);
    const std::size_t tip = model.corner_count() - 1;
    for (const auto& [hold, ratio] : {std::pair{"points", 1.0}, std::pair{"corners", 1.15}}) {
        NodeRun pin = pin_up_to(cubes, 2.75 * h, hold);
        const auto state = settled(cubes, pin);
        const double sag = model.corner_position(tip).y() - state->x[tip].y();
        EXPECT_NEAR(sag / expected, ratio, 0.04) << hold;
    }
}

TEST(HeldPoints, TurnAndFollowCarryTheEnd)
{
    const geometry::Cubes model = beam();
    const Value cubes = Value::of(model);
    NodeRun turn = pin_up_to(cubes, 2.5 * h);
    turn.param("rotate_degrees").is = Vector{90, 0, 0};
    // The same, carried by a mesh with a vertex a corner: x stays, (y, z) goes to (-z, y).
    geometry::TriMesh mesh;
    mesh.topology = std::make_shared<geometry::MeshTopology>();
    std::vector<Vec3> goal;
    for (const Vec3& p : geometry::corner_positions(model)) {
        goal.emplace_back(p.x(), -p.z(), p.y());
        mesh.positions.push_back(goal.back().cast<float>());
    }
    NodeRun follow = pin_up_to(cubes, 2.5 * h);
    follow.inputs["follow"] = {Value::of(mesh)};
    for (NodeRun* pin : {&turn, &follow}) {
        const auto pins = pin->run().as<physics::Pins>();
        ASSERT_EQ(pins->matter.cubes.size(), 3u);
        for (std::size_t i = 0; i < pins->matter.corner.size(); ++i) {
            EXPECT_LT((pins->matter.target[i] - goal[pins->matter.corner[i]]).norm(), 1e-8);
        }
    }
    // Through a quarter turn in 12 frames, with no weight: the beam comes to lie as it was turned.
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.param("gravity").is = Vector{0, 0, 0};
    Value state;
    for (int frame = 0; frame <= 24; ++frame) {
        turn.param("rotate_degrees").is = Vector{std::min(90.0, 7.5 * frame), 0, 0};
        simulate.inputs["pins"] = {turn.run()};
        state = simulate.run();
        simulate.previous = {state};
    }
    const auto end = state.as<physics::State>();
    for (std::size_t k = 0; k < goal.size(); ++k) EXPECT_LT((end->x[k] - goal[k]).norm(), 1e-4);
}

TEST(HeldPoints, SaysWhereItDoesNotServe)
{
    const Value cubes = Value::of(beam());
    NodeRun none = pin_up_to(cubes, -1);
    none.param("box.size").is = Vector{0, 0, 0};
    none.run();
    ASSERT_EQ(none.warnings.size(), 1u);
    EXPECT_NE(none.warnings[0].find("nothing is pinned"), std::string::npos);
    NodeRun rim = pin_up_to(cubes, h);
    rim.param("where").is = std::string("rim");
    EXPECT_THROW(rim.run(), std::invalid_argument);
    NodeRun simulate("Simulate");
    simulate.inputs["cubes"] = {cubes};
    simulate.inputs["pins"] = {pin_up_to(cubes, h).run()};
    simulate.param("method").is = std::string("lattice");
    try {
        simulate.run();
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("hold = corners"), std::string::npos);
    }
}

TEST(Pin, ThatFollowsAMeshTellsThatItsOwnMotionHasNoEffect)
{
    const geometry::Cubes model = beam();
    geometry::TriMesh mesh;
    for (const Vec3& p : corner_positions(model)) mesh.positions.push_back(p.cast<float>());
    for (const char* const hold : {"corners", "points"}) {
        NodeRun pin = pin_up_to(Value::of(model), 2.75 * h, hold);
        pin.inputs["follow"] = {Value::of(mesh)};
        pin.run();
        EXPECT_TRUE(pin.warnings.empty());
        pin.param("translate").is = Vector{0, 1, 0};
        pin.param("pivot").is = Vector{0, 0, 1};
        pin.run();
        ASSERT_EQ(pin.warnings.size(), 1u);
        EXPECT_EQ(pin.warnings[0].rfind("no effect of translate, pivot, because", 0), 0u)
            << pin.warnings[0];
    }
}

TEST(Pin, TellsThatItsMotionAlongFreeAxesHasNoEffect)
{
    for (const char* const hold : {"corners", "points"}) {
        NodeRun pin = pin_up_to(Value::of(beam()), 2.75 * h, hold);
        pin.param("axes").is = std::string("y");
        pin.param("translate").is = Vector{0, 1, 0};
        pin.run();
        EXPECT_TRUE(pin.warnings.empty());
        pin.param("translate").is = Vector{1, 1, 0};
        pin.run();
        ASSERT_EQ(pin.warnings.size(), 1u);
        EXPECT_EQ(pin.warnings[0].rfind("no effect of translate along x, because `axes`", 0), 0u)
            << pin.warnings[0];
    }
}

}  // namespace
