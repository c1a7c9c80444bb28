// What `aspic card --motion` says of a simulation, by numbers that are known beforehand.

#include "runtime/commands/command_line.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>

namespace {

// One cube of 0.1 m, 1 kg, that falls onto the ground at y = 0, and what moves it.
std::string falling_box(const std::string& inputs, const std::string& params,
                        const std::string& nodes = "")
{
    return R"({ "aspic": 1, "frames": { "last": 6, "fps": 24 }, "nodes": {
    "box": { "type": "Primitive@1", "params": {
        "shape": "box", "box": { "size": [0.1, 0.1, 0.1] }, "centre": [0, 0.05, 0] } },
    "body": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": {
        "method": "solid", "size": 0.1, "matter": { "density": 1000, "young": 1e5 } } },)" +
           nodes + R"(
    "sim": { "type": "Simulate@3", "inputs": { "cubes": "body.cubes")" +
           inputs + R"( }, "params": { )" + params + " } } } }";
}

struct MotionSaid {
    int exit = 0;
    std::string out, err;
    nlohmann::json json;  // the last line
};

MotionSaid card_of(const std::string& text, std::vector<std::string> more)
{
    const files::Folder folder;
    std::ostringstream o, e;
    runtime::Console console{o, e, false, {}, {}, "test"};
    std::vector<std::string> args{"card", folder.write("sim.json", text).string(),
                                  "--no-disk-cache"};
    args.insert(args.end(), more.begin(), more.end());
    MotionSaid said;
    said.exit = runtime::run_command_line(args, nodes::registry(), console);
    said.out = o.str(), said.err = e.str();
    const auto line = said.out.rfind("{\"simulation\"");
    if (line != std::string::npos) said.json = nlohmann::json::parse(said.out.substr(line));
    return said;
}

const std::vector<std::string> as_json{"--motion", "--json"};

TEST(MotionCard, ABodyThatFallsKeepsItsEnergyUnderTheMidpointRule)
{
    const MotionSaid said = card_of(
        falling_box("", R"("step": { "integrator": "implicit_midpoint", "tolerance": 1e-8 })"),
        as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    EXPECT_EQ(said.json["simulation"], "sim");
    EXPECT_EQ(said.json["frames"], 6);
    const auto& card = said.json["card"];
    // Free fall is exact: nothing but the tolerance is left over, and nothing is touched.
    EXPECT_LT(card["nonlinear residual, of the forces at work"].get<double>(), 1e-6);
    EXPECT_LT(card["energy gained, of the most there was"].get<double>(), 1e-9);
    EXPECT_LT(card["energy lost, of the most there was"].get<double>(), 1e-9);
    EXPECT_EQ(card["contact depth, m"], 0);
}

// Free fall is exact. A box that hits the ground at 2.4 m/s is stopped within the step of 1/24 s,
// half of which it is off by: 0.05 m, half of a cube. In steps by their error it is off by less.
TEST(MotionCard, TellsTheErrorOfATimeStep)
{
    const char* const name = "time step error, in cubes";
    const MotionSaid falls = card_of(falling_box("", ""), as_json);
    ASSERT_EQ(falls.exit, runtime::exit_ok) << falls.err;
    EXPECT_LT(falls.json["card"][name].get<double>(), 1e-6);
    const auto lands = [name](const std::string& step) {
        return card_of(falling_box(R"(, "colliders": "ground.collider")",
                                   R"("bodies": [{ "velocity": [0, -2.4, 0] }], "step": { )" +
                                       step + " }",
                                   R"("ground": { "type": "Ground@1" },)"),
                       as_json)
            .json["card"][name];
    };
    EXPECT_NEAR(lands(R"("substeps": 1)").get<double>(), 0.5, 0.15);
    EXPECT_LT(lands(R"("substeps": 0, "error": 0.05)").get<double>(), 0.1);
    EXPECT_TRUE(lands(R"("integrator": "implicit_midpoint")").is_null());
}

TEST(MotionCard, SeveralBodiesAreCountedTogether)
{
    std::string two =
        falling_box("", R"("step": { "integrator": "implicit_midpoint", "tolerance": 1e-8 })", R"(
    "other": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": {
        "method": "solid", "size": 0.05, "matter": { "density": 500, "young": 1e5 } } },)");
    const std::string one = R"("body.cubes")";
    two.replace(two.find(one), one.size(), R"(["body.cubes", "other.cubes"])");
    const MotionSaid said = card_of(two, as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    EXPECT_LT(said.json["card"]["energy gained, of the most there was"].get<double>(), 1e-9);
    EXPECT_LT(said.json["card"]["energy lost, of the most there was"].get<double>(), 1e-9);
}

TEST(MotionCard, ImplicitEulerKeepsTheEnergyOfWhatFalls)
{
    const MotionSaid said = card_of(falling_box("", R"("step": { "tolerance": 1e-8 })"), as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    const auto& card = said.json["card"];
    EXPECT_LT(card["energy lost, of the most there was"].get<double>(), 1e-6);
    EXPECT_LT(card["energy gained, of the most there was"].get<double>(), 1e-6);
}

TEST(MotionCard, ImplicitEulerLosesVibration)
{
    // A spin of 52 rad/s stretches the box by some percent; steps of 1/24 s damp the vibration.
    const MotionSaid said =
        card_of(falling_box("", R"("initial_spin_degrees": [0, 3000, 0])"), as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    const double lost = said.json["card"]["energy lost, of the most there was"];
    EXPECT_GT(lost, 0.003);
    EXPECT_LT(lost, 0.3);
}

TEST(MotionCard, WhatSinksSlowlyLosesNoMoreThanThereWas)
{
    // Drag of 100 / s keeps it at 0.1 m/s: 5 mJ of motion, and in five frames 0.17 J of its weight.
    std::string sinking = falling_box("", "");
    const std::string matter = R"("young": 1e5)";
    sinking.replace(sinking.find(matter), matter.size(), matter + R"(, "mass_damping": 100)");
    const MotionSaid said = card_of(sinking, as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    const double lost = said.json["card"]["energy lost, of the most there was"];
    EXPECT_GT(lost, 0.9);
    EXPECT_LE(lost, 1);
}

TEST(MotionCard, TellsHowDeepABodyIsInTheGround)
{
    const char* const ground = R"( "ground": { "type": "Ground@1" },)";
    const MotionSaid said =
        card_of(falling_box(R"(, "colliders": ["ground.collider"])", "", ground), as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    // It stands on it from the first frame on. Its weight, 9.81 N, is borne by springs: it is in by
    // more than nothing, and by less than a hundredth of it.
    const double depth = said.json["card"]["contact depth, m"];
    EXPECT_GT(depth, 0);
    EXPECT_LT(depth, 1e-3);
}

TEST(MotionCard, EnergyIsNotKnownWhereOthersDoWork)
{
    const char* const wind = R"( "wind": { "type": "Force@1" },)";
    const MotionSaid said =
        card_of(falling_box(R"(, "forces": ["wind.force"])", "", wind), as_json);
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    EXPECT_TRUE(said.json["card"]["energy gained, of the most there was"].is_null());
    EXPECT_TRUE(said.json["card"]["contact depth, m"].is_number());
}

TEST(MotionCard, OfOtherMethodsTheEnergyIsNotKnown)
{
    const MotionSaid springs = card_of(falling_box("", R"("method": "springs")"), as_json);
    ASSERT_EQ(springs.exit, runtime::exit_ok) << springs.err;
    EXPECT_TRUE(springs.json["card"]["energy lost, of the most there was"].is_null());
    EXPECT_TRUE(springs.json["card"]["nonlinear residual, of the forces at work"].is_number());
}

TEST(MotionCard, TheTextNamesTheSimulationAndItsFrames)
{
    const MotionSaid said = card_of(falling_box("", ""), {"--motion"});
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    EXPECT_NE(said.out.find("body "), std::string::npos) << said.out;
    EXPECT_NE(said.out.find("sim "), std::string::npos) << said.out;
    EXPECT_NE(said.out.find("6 frames"), std::string::npos) << said.out;
    EXPECT_NE(said.out.find("energy lost, of the most there was"), std::string::npos) << said.out;
    const MotionSaid none = card_of(R"({ "aspic": 1, "nodes": {} })", {"--motion"});
    EXPECT_EQ(none.exit, runtime::exit_failed);
    EXPECT_NE(none.err.find("--motion needs Simulate"), std::string::npos) << none.err;
}

}  // namespace
