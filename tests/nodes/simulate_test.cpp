#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

namespace {

using graph::Value;

// Runs one node on the values of its inputs by name, with parameters changed by name.
struct OneNode {
    const graph::NodeType& type;
    std::map<std::string, std::vector<Value>> inputs;
    std::vector<Value> previous;
    graph::ParamValues params;
    std::vector<std::string> warnings;

    explicit OneNode(const char* name)
        : type(*nodes::registry().find(name)), previous(type.previous.size())
    {
        for (const auto& p : type.params) params.push_back(p.fallback);
    }

    graph::ParamValue& param(const std::string& name)
    {
        for (std::size_t i = 0; i < params.size(); ++i) {
            if (type.params[i].name == name) return params[i];
        }
        throw std::logic_error("no parameter " + name);
    }

    Value run()
    {
        std::vector<std::vector<Value>> by_port;
        for (const auto& port : type.inputs) by_port.push_back(inputs[port.name]);
        graph::Context context(1, {1, 10, 24}, type.reads);
        context.warn = [this](const std::string& text) { warnings.push_back(text); };
        std::vector<std::shared_ptr<const void>> prepared;
        for (const auto& p : type.preparations) {
            prepared.push_back(p.build({by_port, params, {}, {}, context}));
        }
        return type.run({by_port, params, previous, prepared, context}).at(0);
    }
};

TEST(Simulate, ABeamPinnedAtOneEndSagsAfterTheFirstFrame)
{
    const Value cubes = Value::of(fixtures::box(6, 1, 1, 0.1, {.young = 1e5}));
    for (const char* method : {"bricks", "springs", "lattice"}) {
        OneNode pin("Pin");
        pin.inputs["cubes"] = {cubes};
        pin.param("where").is = std::string("ends");
        auto& ends = std::get<graph::ParamValues>(pin.param("ends").is);
        ends[1].is = std::string("low");
        const Value pins = pin.run();
        EXPECT_EQ(pins.as<physics::Pins>()->corner.size(), 8u);  // two planes of four corners

        OneNode simulate("Simulate");
        simulate.param("method").is = std::string(method);
        // Enough steps for the lattice to be as stiff as the material, so that nothing is warned
        // of.
        std::get<graph::ParamValues>(simulate.param("step").is)[1].is = std::int64_t{4};
        simulate.inputs["cubes"] = {cubes};
        simulate.inputs["pins"] = {pins};
        simulate.inputs["colliders"] = {OneNode("Ground").run()};
        simulate.inputs["forces"] = {OneNode("Force").run()};
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

TEST(Simulate, SpinAndVelocityAreThoseAskedFor)
{
    const Value cubes = Value::of(fixtures::box(2, 2, 2, 1));
    OneNode simulate("Simulate");
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

TEST(Pin, SaysWhenNothingIsThereAndWhenTheMeshIsMissing)
{
    OneNode pin("Pin");
    pin.inputs["cubes"] = {Value::of(fixtures::box(1, 1, 1, 0.1))};
    auto& box = std::get<graph::ParamValues>(pin.param("box").is);
    box[0].is = std::array<double, 3>{9, 9, 9};
    EXPECT_TRUE(pin.run().as<physics::Pins>()->corner.empty());
    EXPECT_EQ(pin.warnings.size(), 1u);
    pin.param("where").is = std::string("material");
    EXPECT_THROW(pin.run(), std::invalid_argument);
}

TEST(Collider, RemembersWhereItWasAFrameAgo)
{
    OneNode collider("Collider");
    const Value first = collider.run();
    collider.previous = {first};
    collider.param("translate").is = std::array<double, 3>{0, 1, 0};
    const auto second = collider.run().as<physics::Collider>();
    EXPECT_EQ(second->before.translation().y(), 0);
    EXPECT_EQ(second->pose.translation().y(), 1);
}

}  // namespace
