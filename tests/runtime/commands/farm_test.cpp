#include "tests/runtime/said.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

using namespace runtime;
using toys::has;
using toys::run;
using toys::Said;

namespace {

using Json = nlohmann::json;

// A simulation, and a file a frame of what is made from it.
const char* const counting = R"({ "aspic": 1, "frames": { "first": 1, "last": 12 },
  "nodes": {
    "clock": { "type": "Clock@1" },
    "sim": { "type": "Accumulate@1", "inputs": { "value": "clock.value" },
             "params": { "seconds": 0.003 } },
    "sum": { "type": "Sum@1", "inputs": { "values": ["sim.value"] }, "params": { "bias": 10 } },
    "write": { "type": "WriteNumber@1", "inputs": { "value": "sum.value" } } },
  "expect": [ { "value": "sum.value", "frame": 1, "min": 11, "max": 11 } ] })";

class Farm : public testing::Test {
protected:
    void SetUp() override { file_ = folder_.write("falling.json", counting).string(); }

    Said farm(std::vector<std::string> more, const std::string& out = "out")
    {
        std::vector<std::string> args{"farm",    file_,
                                      "--out",   (folder_.path / out).string(),
                                      "--cache", (folder_.path / "cache").string()};
        args.insert(args.end(), more.begin(), more.end());
        return run(args);
    }
    Json plan(std::vector<std::string> more = {})
    {
        more.insert(more.end(), {"--plan", "--json"});
        const Said said = farm(more);
        EXPECT_EQ(said.exit, exit_ok) << said.err;
        return Json::parse(said.out);
    }

    toys::Folder folder_;
    std::string file_;
};

}  // namespace

TEST_F(Farm, APlanNamesTasksAndWhatTheyWaitFor)
{
    // Nothing is measured: 12 frames of the simulation and 12 of the files, 1 s each.
    const Json p = plan({"--task-seconds", "4"});
    ASSERT_EQ(p["tasks"].size(), 5u) << p;
    EXPECT_EQ(p["tasks"][0]["name"], "falling.chain-sim");
    EXPECT_EQ(p["tasks"][1]["name"], "falling.frames-1");
    EXPECT_EQ(p["tasks"][1]["frames"], "1-4");
    EXPECT_EQ(p["tasks"][1]["after"], Json::array({"falling.chain-sim"}));
    EXPECT_EQ(p["tasks"][4]["name"], "falling.last");
    EXPECT_EQ(p["tasks"][4]["after"].size(), 3u);
    EXPECT_FALSE(p["shots"][0]["measured"]);
    EXPECT_EQ(p["machines"][0]["seconds"], 24);
    EXPECT_EQ(p["machines"][2]["seconds"], 16) << "the chain, then 3 tasks of 4 s side by side";
    EXPECT_FALSE(std::filesystem::exists(folder_.path / "out")) << "a plan writes nothing";
}

TEST_F(Farm, APlanIsReadByPeople)
{
    const Said said = farm({"--plan", "--task-seconds", "4"});
    EXPECT_TRUE(has(said.out, "falling: 0 of 12 results are in the cache; no time was measured"))
        << said.out;
    EXPECT_TRUE(has(said.out, "longest path: 16 s: falling.chain-sim, falling.frames-1,"))
        << said.out;
}

TEST_F(Farm, APlanKnowsWhatIsInTheCacheAndWhatItTook)
{
    ASSERT_EQ(run({"cook", file_, "--out", (folder_.path / "out").string(), "--cache",
                   (folder_.path / "cache").string(), "--frames", "1-6"})
                  .exit,
              exit_ok);
    const Json p = plan({"--task-seconds", "0.003"});
    EXPECT_EQ(p["shots"][0]["results"], 12);
    EXPECT_EQ(p["shots"][0]["held"], 6);
    EXPECT_TRUE(p["shots"][0]["measured"]);
    const double chain = p["tasks"][0]["seconds"];
    EXPECT_GE(chain, 6 * 0.003) << "six frames of the simulation are left";
    EXPECT_LT(chain, 12 * 0.003 * 20) << "on any machine";
    // A file that was removed is written again.
    std::filesystem::remove(folder_.path / "out/3number.txt");
    EXPECT_EQ(plan()["shots"][0]["held"], 5);
}

TEST_F(Farm, EachSettingIsACookOfItsOwn)
{
    const Json p = plan({"--vary", "sum.bias=1,2,3", "--task-seconds", "4"});
    ASSERT_EQ(p["shots"].size(), 3u);
    EXPECT_EQ(p["shots"][1]["name"], "falling-002");
    EXPECT_EQ(p["shots"][1]["set"], Json::array({"sum.bias=2"}));
    EXPECT_TRUE(has(p["shots"][1]["folder"], "/out/002"));
    int chains = 0;
    for (const Json& t : p["tasks"]) chains += t["stage"] == "chain";
    EXPECT_EQ(chains, 1) << "the simulation is the same";
}

TEST_F(Farm, WhatMakesNoSenseIsRefused)
{
    EXPECT_EQ(run({"farm", "--plan"}).exit, exit_usage);
    EXPECT_EQ(farm({}).exit, exit_usage) << "neither a plan nor an engine";
    EXPECT_EQ(farm({"--plan", "--vary", "nothing"}).exit, exit_usage);
    const std::string twin = folder_.write("other/falling.json", counting).string();
    const Said said = run({"farm", file_, twin, "--plan"});
    EXPECT_EQ(said.exit, exit_usage);
    EXPECT_TRUE(has(said.err, "'falling' twice")) << said.err;
}
