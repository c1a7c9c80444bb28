// The accuracy card that every cook writes: what Voxelize and Simulate tell, whether they ran or
// came out of the cache.

#include "nodes/registry.hpp"
#include "runtime/commands/accuracy_card.hpp"
#include "runtime/commands/command_line.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sstream>

namespace {

// A box of 1,000 kg/m^3 in one cube and a half, which falls for four frames.
std::string falling(const std::string& body = "body", const std::string& more = R"("size": 0.1)",
                    const std::string& height = "0.15")
{
    return R"({ "aspic": 1, "frames": { "last": 4, "fps": 24 }, "nodes": {
    "box": { "type": "Primitive@1", "params": {
        "shape": "box", "box": { "size": [0.1, )" +
           height + R"(, 0.1] } } },
    ")" + body +
           R"(": { "type": "Voxelize@1", "inputs": { "mesh": "box.mesh" }, "params": {
        "method": "solid", "matter": { "density": 1000, "young": 1e5 }, )" +
           more + R"( } },
    "sim": { "type": "Simulate@3", "inputs": { "cubes": ")" +
           body + R"(.cubes" }, "params": {
        "step": { "integrator": "implicit_midpoint", "tolerance": 1e-8 } } },
    "shape": { "type": "Embed@1", "inputs": {
        "mesh": "box.mesh", "cubes": ")" +
           body + R"(.cubes", "state": "sim.state" } },
    "write": { "type": "WriteMesh@1", "inputs": { "mesh": "shape.mesh" }, "params": {
        "path": "box.####.obj" } } } })";
}

struct Cooked {
    std::string err;
    nlohmann::json accuracy;  // of the manifest
};

// With a cache of its own, kept between cooks.
class AccuracyOfCooks : public ::testing::Test {
protected:
    Cooked cook(const std::string& text, const char* out, std::vector<std::string> more = {})
    {
        std::ostringstream o, e;
        runtime::Console console{o, e, false, {}, {}, "test"};
        const auto folder = folder_.path / out;
        std::vector<std::string> args{"cook",    folder_.write("box.json", text).string(),
                                      "--cache", (folder_.path / "cache").string(),
                                      "--out",   folder.string()};
        args.insert(args.end(), more.begin(), more.end());
        EXPECT_EQ(runtime::run_command_line(args, nodes::registry(), console), runtime::exit_ok)
            << e.str();
        said_ = e.str() + o.str();
        const auto manifest = nlohmann::json::parse(files::bytes_of(folder / "manifest.json"));
        return {said_, manifest.value("accuracy", nlohmann::json())};
    }

    const files::Folder folder_;
    std::string said_;
};

TEST_F(AccuracyOfCooks, ACookWritesWhatItsNodesTell)
{
    const Cooked made = cook(falling(), "a");
    ASSERT_EQ(made.accuracy.size(), 2u) << made.accuracy;
    const auto& body = made.accuracy[0];
    EXPECT_EQ(body["body"], "body");
    EXPECT_NEAR(body["card"]["volume, m^3"]["mesh"].get<double>(), 1.5e-3, 1e-9);
    EXPECT_NEAR(body["card"]["mass, kg"]["cubes"].get<double>(), 1.5, 1e-6);
    const auto& sim = made.accuracy[1];
    EXPECT_EQ(sim["simulation"], "sim");
    EXPECT_EQ(sim["frames"], 4);
    EXPECT_LT(sim["card"]["nonlinear residual, of the forces at work"].get<double>(), 1e-6);
    EXPECT_LT(sim["card"]["energy gained, of the most there was"].get<double>(), 1e-9);
    EXPECT_NE(made.err.find("accuracy: 'body': 2 cubes; against the mesh: "), std::string::npos)
        << made.err;
    EXPECT_NE(made.err.find("accuracy: 'sim': 4 frames: nonlinear residual "), std::string::npos)
        << made.err;
}

TEST_F(AccuracyOfCooks, TheCacheTellsTheSame)
{
    const Cooked made = cook(falling(), "a");
    EXPECT_EQ(cook(falling(), "a").accuracy, made.accuracy);
    EXPECT_NE(said_.find(" 0 cooked"), std::string::npos) << said_;
    EXPECT_EQ(cook(falling(), "b").accuracy, made.accuracy);
    const Cooked json = cook(falling(), "c", {"--json"});
    EXPECT_NE(json.err.find(R"({"event":"accuracy","simulation":"sim","frames":4,)"),
              std::string::npos)
        << json.err;
}

TEST_F(AccuracyOfCooks, FiguresGoToTheNodeThatWouldMakeTheResult)
{
    cook(falling("body"), "a");
    const Cooked renamed = cook(falling("crate"), "a");
    ASSERT_EQ(renamed.accuracy.size(), 2u) << renamed.accuracy;
    EXPECT_EQ(renamed.accuracy[0]["body"], "crate");
}

TEST_F(AccuracyOfCooks, AnEditThatLeavesTheCubesAsTheyAreTellsOfThemOnce)
{
    const Cooked made = cook(falling(), "a");
    EXPECT_EQ(cook(falling("body", R"("size": 0.1, "max_cubes": 77)"), "a").accuracy,
              made.accuracy);
}

TEST_F(AccuracyOfCooks, AnEditThatMakesOtherCubesTellsOfThose)
{
    cook(falling(), "a");
    const Cooked taller = cook(falling("body", R"("size": 0.1)", "0.16"), "a");
    ASSERT_EQ(taller.accuracy.size(), 2u) << taller.accuracy;
    const auto& volume = taller.accuracy[0]["card"]["volume, m^3"];
    EXPECT_NEAR(volume["mesh"].get<double>(), 1.6e-3, 1e-9);
}

TEST_F(AccuracyOfCooks, WhatGathersFramesTellsOfAll)
{
    std::string text = falling();
    const std::string write = R"("write": {)";
    text.replace(text.find(write), write.size(), R"("bounds": { "type": "MotionBounds@1",
        "inputs": { "mesh": "shape.mesh" } }, "write": {)");
    const Cooked made = cook(text, "a", {"--node", "bounds"});
    ASSERT_EQ(made.accuracy.size(), 2u) << made.accuracy;
    EXPECT_EQ(made.accuracy[1]["frames"], 4);
    EXPECT_EQ(cook(text, "a", {"--node", "bounds"}).accuracy, made.accuracy);
}

TEST_F(AccuracyOfCooks, ANameThatWentToAnotherNodeTellsOfThatOne)
{
    cook(falling(), "a");
    cook(falling("body", R"("size": 0.1, "max_cubes": 77)"), "a");
    // The cubes that "body" made are those of "crate" now.
    std::string text = falling("crate", R"("size": 0.1, "max_cubes": 77)");
    const std::string write = R"("write": {)";
    text.replace(text.find(write), write.size(), R"("body": { "type": "Voxelize@1",
        "inputs": { "mesh": "box.mesh" }, "params": { "method": "solid", "size": 0.05 } },
    "count": { "type": "Measure@1", "inputs": { "cubes": "body.cubes" }, "params": {
        "what": "cubes" } }, "write": {)");
    const Cooked both = cook(text, "a", {"--node", "write", "--node", "count"});
    ASSERT_EQ(both.accuracy.size(), 3u) << both.accuracy;
    for (const auto& card : both.accuracy) {
        if (!card.contains("body")) continue;
        const int cubes = card["body"] == "crate" ? 2 : 12;
        EXPECT_EQ(card["card"]["cubes"]["cubes"], cubes) << card;
    }
}

TEST_F(AccuracyOfCooks, OfOneFrameNoBalanceIsKnown)
{
    const Cooked one = cook(falling(), "a", {"--frames", "3"});
    ASSERT_EQ(one.accuracy.size(), 2u) << one.accuracy;
    EXPECT_TRUE(one.accuracy[1]["card"]["energy gained, of the most there was"].is_null());
    EXPECT_EQ(one.err.find("energy gained"), std::string::npos) << one.err;
}

// Nothing is solved in free fall; one iteration cannot stop the box on the floor, which is 0.045 m
// below it. It falls g t^2 / 2 = 0.009 m to frame 2, and would fall 0.077 m to frame 4.
TEST_F(AccuracyOfCooks, FramesThatDidNotConvergeAreCounted)
{
    std::string text = falling();
    const auto replace = [&](const std::string& was, const std::string& is) {
        text.replace(text.find(was), was.size(), is);
    };
    replace(R"("integrator": "implicit_midpoint", "tolerance": 1e-8)", R"("solver_iterations": 1)");
    replace(R"("cubes": "body.cubes" }, "params": {)",
            R"("cubes": "body.cubes", "colliders": ["floor.collider"] }, "params": {)");
    replace(R"("write": {)", R"("floor": { "type": "Ground@1", "params": { "height": -0.12 } },
    "write": {)");
    const Cooked made = cook(text, "a", {"--quiet"});
    ASSERT_EQ(made.accuracy.size(), 2u) << made.accuracy;
    const auto frames =
        made.accuracy[1]["card"]["did not converge, frames"].get<std::vector<int>>();
    ASSERT_FALSE(frames.empty());
    EXPECT_GE(frames.front(), 3);
    EXPECT_EQ(frames.back(), 4);
    const std::string verdict = "warning: 'sim': " + std::to_string(frames.size()) +
                                " of 4 frames did not converge (" +
                                (frames.size() == 2 ? "3, 4" : "4") + ")\n";
    EXPECT_NE(made.err.find(verdict), std::string::npos) << made.err;
    EXPECT_EQ(cook(text, "a").accuracy, made.accuracy) << "from the cache";
    EXPECT_EQ(cook(falling(), "b").err.find("did not converge"), std::string::npos);
}

TEST_F(AccuracyOfCooks, APictureOfAWholeShotTellsOfItsFrames)
{
    std::string text = falling();
    const std::string write = R"("write": {)";
    text.replace(text.find(write), write.size(), R"("bounds": { "type": "MotionBounds@1",
        "inputs": { "mesh": "shape.mesh" } }, "picture": { "type": "Render@2", "inputs": {
        "mesh": ["shape.mesh"], "shot": "bounds.points" }, "params": {
        "width": 32, "height": 32 } }, "write": {)");
    const Cooked made = cook(text, "a", {"--node", "picture", "--frames", "1-2"});
    ASSERT_EQ(made.accuracy.size(), 2u) << made.accuracy;
    EXPECT_EQ(made.accuracy[1]["frames"], 2);
}

TEST_F(AccuracyOfCooks, WhatIsWorstIsTold)
{
    // Half a cube thick: (0.2 / 0.1)^2 times too stiff.
    const Cooked thin = cook(falling("body", R"("size": 0.2)", "0.1"), "a");
    const auto& bending = thin.accuracy[0]["card"]["stiffness in bending, of the true one"];
    EXPECT_NEAR(bending["cubes"].get<double>(), 4, 0.5);
    EXPECT_NE(thin.err.find("stiffness in bending +"), std::string::npos) << thin.err;
}

TEST_F(AccuracyOfCooks, NothingIsSaidOfTheBendingOfWhatNothingBends)
{
    const auto rigid = [](const std::string& nodes, const char* is) {
        std::string text = falling("body", R"("size": 0.2)", "0.1");
        const std::string step =
            R"("step": { "integrator": "implicit_midpoint", "tolerance": 1e-8 })";
        text.replace(text.find(step), step.size(),
                     std::string(R"("bodies": [{ "rigid": )") + is + " }]");
        text.replace(text.find(R"("write": {)"), 0, nodes);
        return text;
    };
    const auto told = [&](const std::string& text) {
        const Cooked made = cook(text, "a");
        const auto& bending = made.accuracy[0]["card"]["stiffness in bending, of the true one"];
        EXPECT_NEAR(bending["cubes"].get<double>(), 4, 0.5);  // the card keeps it
        const bool warned = made.err.find("times too stiff in bending") != std::string::npos;
        EXPECT_EQ(warned, made.err.find("stiffness in bending +") != std::string::npos);
        return warned;
    };
    EXPECT_FALSE(told(rigid("", "true")));
    EXPECT_FALSE(told(rigid("", "true"))) << "from the cache";
    // The same body, and the same cache, where it bends.
    EXPECT_TRUE(told(rigid("", "false")));
    EXPECT_FALSE(told(rigid("", "true")));
    EXPECT_TRUE(told(rigid(R"("modes": { "type": "Modes@1", "inputs": {
        "cubes": "body.cubes", "mesh": "box.mesh" } }, )",
                           "true")));
    // By way of what hands cubes on.
    const std::string other = R"("other": { "type": "LocalMatter@1", "inputs": {
        "cubes": "body.cubes" } }, "sim2": { "type": "Simulate@3", "inputs": {
        "cubes": "other.cubes" }, "params": { "bodies": [{ "rigid": )";
    EXPECT_FALSE(told(rigid(other + "true }] } }, ", "true")));
    EXPECT_TRUE(told(rigid(other + "false }] } }, ", "true")));
    // Cubes that are only drawn.
    std::string drawn = rigid("", "true");
    const auto sim = drawn.find(R"("sim": {)");
    drawn.replace(sim, drawn.find(R"("write": {)") - sim,
                  R"("shape": { "type": "CubeMesh@1", "inputs": { "cubes": "body.cubes" } }, )");
    EXPECT_TRUE(told(drawn));
}

TEST_F(AccuracyOfCooks, WhyNothingIsComparedWhereItsPartsOverlapIsSaid)
{
    std::string text = falling();
    const std::string link = R"("inputs": { "mesh": "box.mesh" }, "params": {
        "method": "solid")";
    std::string merged = link;
    merged.replace(merged.find("box.mesh"), 8, "both.mesh");
    ASSERT_NE(text.find(link), std::string::npos);
    text.replace(text.find(link), link.size(), merged);
    text.replace(text.find(R"("write": {)"), 0, R"("moved": { "type": "Transform@1", "inputs": {
        "mesh": "box.mesh" }, "params": { "translate": [0.05, 0, 0] } },
        "both": { "type": "Merge@1", "inputs": { "meshes": ["box.mesh", "moved.mesh"] } }, )");
    const Cooked made = cook(text, "a");
    EXPECT_NE(made.err.find("nothing against the mesh, as its parts overlap"), std::string::npos)
        << made.err;
    EXPECT_EQ(made.err.find("volume -"), std::string::npos) << made.err;
}

// A box of one cube and a half: nothing is said. In cubes of 10 m it is a speck.
TEST_F(AccuracyOfCooks, AMeshThatIsSmallAgainstItsCubesIsWarnedOfOnce)
{
    const char* const warning = "times the volume of the mesh";
    EXPECT_EQ(cook(falling(), "a").err.find(warning), std::string::npos);
    const Cooked speck = cook(falling("body", R"("size": 10)"), "b");
    const auto at = speck.err.find(warning);
    ASSERT_NE(at, std::string::npos) << speck.err;
    EXPECT_EQ(speck.err.find(warning, at + 1), std::string::npos) << speck.err;
    EXPECT_NE(speck.err.find("set `size` to 0.029 m or less"), std::string::npos) << speck.err;
}

TEST(AccuracyCard, WarnsOfDepthsBeyondACubeAndOfEnergyFromNothing)
{
    using graph::Over;
    const auto warnings = [](double depth, double gained) {
        runtime::AccuracyCard card{"sim", "simulation", 4, {}};
        card.lines.push_back({{"contact depth, m", depth, 0.05, Over::largest}, 3});
        card.lines.push_back({{"energy gained, of the most there was", gained,
                               graph::Figure::unknown, Over::balance}});
        card.lines.push_back(
            {{"energy lost, of the most there was", 0.9, graph::Figure::unknown, Over::balance}});
        return runtime::card_warnings(card);
    };
    constexpr double unknown = graph::Figure::unknown;
    EXPECT_TRUE(warnings(0.049, 0.49).empty());
    EXPECT_TRUE(warnings(unknown, unknown).empty());
    ASSERT_EQ(warnings(0.055, 1.03).size(), 2u);
    EXPECT_TRUE(warnings(0.055, 0)[0].starts_with(
        "'sim': a contact depth of 0.055 m (frame 3) is more than a cube of 0.05 m"));
    EXPECT_TRUE(warnings(0, 1.03)[0].starts_with("'sim': energy gained 103 %, and nothing"));
}

TEST(AccuracyCard, NamesStepsByTheirErrorWhereOneIsOffByACube)
{
    using graph::Over;
    constexpr double unknown = graph::Figure::unknown;
    const auto summary = [](double error, double within = graph::Figure::unknown) {
        runtime::AccuracyCard card{"sim", "simulation", 4, {}};
        card.lines.push_back({{"time step error, in cubes", error, within, Over::largest}, 3});
        return runtime::card_summary(card);
    };
    EXPECT_EQ(summary(unknown), "'sim': 4 frames");
    EXPECT_EQ(summary(2.5, 0.1), "'sim': 4 frames: time step error 2.5 cubes (frame 3)")
        << "they are by their error already";
    EXPECT_EQ(summary(0.25), "'sim': 4 frames: time step error 0.25 cubes (frame 3)");
    EXPECT_EQ(summary(2.5), "'sim': 4 frames: time step error 2.5 cubes (frame 3; step.substeps = "
                            "0 takes steps by their error)");
}

}  // namespace
