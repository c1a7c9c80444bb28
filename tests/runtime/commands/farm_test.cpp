#include "runtime/commands/manifest.hpp"
#include "tests/runtime/said.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

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

    // The engine `local`, with tasks in this process instead of their own. Those that `deadly`
    // names are killed before they begin.
    Said local(std::vector<std::string> more, const std::string& deadly = "none")
    {
        std::vector<std::string> args{"farm",     file_,
                                      "--out",    (folder_.path / "out").string(),
                                      "--cache",  (folder_.path / "cache").string(),
                                      "--engine", "local"};
        if (std::find(more.begin(), more.end(), "--at-once") == more.end())
            more.insert(more.end(), {"--at-once", "2"});
        args.insert(args.end(), more.begin(), more.end());
        std::ostringstream out, err;
        Console console{out, err, false, {}, {}, "1.2.3"};
        console.program = "aspic";
        console.run_program = [&](const std::vector<std::string>& words, const std::stop_token&) {
            // sh -c SCRIPT LOG aspic cook ...
            EXPECT_EQ(words.at(4), "aspic");
            if (has(words[3], deadly)) return 128 + 9;
            if (before_task) before_task(words[3]);
            Said said = run({words.begin() + 5, words.end()});
            std::ofstream(words[3]) << said.out << said.err;
            if (after_task) after_task(words[3]);
            return said.exit;
        };
        const int exit = run_command_line(args, toys::registry(), console);
        return {exit, out.str(), err.str()};
    }
    // The engine `slurm`, where each program that is asked for answers nothing and succeeds.
    Said slurm(std::vector<std::string> more, int status = 0)
    {
        std::vector<std::string> args{"farm",     file_,
                                      "--out",    (folder_.path / "out").string(),
                                      "--cache",  (folder_.path / "cache").string(),
                                      "--engine", "slurm"};
        args.insert(args.end(), more.begin(), more.end());
        std::ostringstream out, err;
        Console console{out, err, false, {}, {}, "1.2.3"};
        console.program = "/opt/with space/aspic";
        console.run_program = [&](const std::vector<std::string>& words, const std::stop_token&) {
            std::ofstream(words.at(3)) << "Invalid partition\n";
            return status;
        };
        const int exit = run_command_line(args, toys::registry(), console);
        return {exit, out.str(), err.str()};
    }
    std::string job_file(const std::string& name) const
    {
        return toys::bytes_of(folder_.path / "out/farm" / name);
    }
    // What a plain cook writes, and what the farm wrote: by name, without the manifests and the
    // job.
    std::map<std::string, std::string> files(const std::string& folder) const
    {
        std::map<std::string, std::string> all;
        for (const auto& f : std::filesystem::directory_iterator(folder_.path / folder)) {
            if (!f.is_regular_file() || f.path().filename() == "manifest.json") continue;
            all[f.path().filename()] = toys::bytes_of(f.path());
        }
        return all;
    }
    std::map<std::string, std::string> cooked()
    {
        EXPECT_EQ(run({"cook", file_, "--out", (folder_.path / "plain").string()}).exit, exit_ok);
        return files("plain");
    }

    toys::Folder folder_;
    std::string file_;
    std::function<void(const std::string&log)> before_task, after_task;  // of the engine `local`
};

struct Mute {
    struct Inputs {
        std::int64_t size = 1;
    };
    struct Outputs {
        toys::Numbers numbers;
    };
    static Outputs run(const Inputs&, const graph::Context&) { return {}; }
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
    // On a busy machine, the clock may have been slow enough to be a task before it.
    double chain = 0;
    for (const Json& task : p["tasks"]) {
        if (task["stage"] == "chain") chain = task["seconds"];
    }
    EXPECT_GE(chain, 6 * 0.003) << "six frames of the simulation are left";
    EXPECT_LT(chain, 12 * 0.003 * 20) << "on any machine";
    // A file that was removed is written again.
    std::filesystem::remove(folder_.path / "out/3number.txt");
    EXPECT_EQ(plan()["shots"][0]["held"], 5);
}

TEST_F(Farm, AShotThatWasNeverCookedIsMeasuredByTheTypesOfOthers)
{
    // Another shot was cooked, without a simulation. The files of the first one are taken to last
    // as long as its files, and the simulation, a type of node whose times are not known, is taken
    // for 1 s a frame: it is a task, which the tasks of the files wait for.
    const std::string other = folder_
                                  .write("other/standing.json", R"({ "aspic": 1,
      "frames": { "first": 1, "last": 12 },
      "nodes": {
        "clock": { "type": "Clock@1" },
        "sum": { "type": "Sum@1", "inputs": { "values": ["clock.value"] } },
        "write": { "type": "WriteNumber@1", "inputs": { "value": "sum.value" } } } })")
                                  .string();
    ASSERT_EQ(run({"cook", other, "--out", (folder_.path / "out/standing").string(), "--cache",
                   (folder_.path / "cache").string(), "--frames", "1-6"})
                  .exit,
              exit_ok);
    const Json p = plan({other, "--task-seconds", "0.001"});
    ASSERT_EQ(p["shots"].size(), 2u);
    EXPECT_TRUE(p["shots"][0]["measured"]) << p["shots"];
    // On a busy machine, the clock may have been slow enough to be a task before it.
    const auto chain = std::find_if(p["tasks"].begin(), p["tasks"].end(),
                                    [](const Json& t) { return t["name"] == "falling.chain-sim"; });
    ASSERT_NE(chain, p["tasks"].end()) << p["tasks"];
    // With what of the others took long enough to be stored, if any did.
    EXPECT_NEAR((*chain)["seconds"].get<double>(), 12, 1);
    ASSERT_NE(chain + 1, p["tasks"].end()) << p["tasks"];
    EXPECT_EQ((*(chain + 1))["after"], Json::array({"falling.chain-sim"}));
    EXPECT_LT((*(chain + 1))["seconds"], 1);
}

TEST_F(Farm, WhatAnotherShotStoredTellsNothingOfASimulation)
{
    // Both shots take the same slow numbers; one of them simulates with these.
    const std::string nodes = R"({ "aspic": 1, "frames": { "first": 1, "last": 12 },
      "nodes": {
        "clock": { "type": "Clock@1" },
        "slow": { "type": "Slow@1", "inputs": { "value": "clock.value" },
                  "params": { "seconds": 0.003 } },
        "write": { "type": "WriteNumber@1", "inputs": { "value": ")";
    const std::string other =
        folder_.write("other/standing.json", nodes + R"(slow.first" } } } })").string();
    const std::string never = folder_
                                  .write("never.json", nodes + R"(sim.value" } },
        "sim": { "type": "Accumulate@1", "inputs": { "value": "slow.first" } } } })")
                                  .string();
    const std::string out = (folder_.path / "out").string();
    const std::string cache = (folder_.path / "cache").string();
    ASSERT_EQ(run({"cook", other, "--out", out + "/standing", "--cache", cache}).exit, exit_ok);
    const Said said = run({"farm", never, "--out", out, "--cache", cache, "--task-seconds", "0.001",
                           "--plan", "--json"});
    ASSERT_EQ(said.exit, exit_ok) << said.err;
    const Json p = Json::parse(said.out);
    double seconds = 0;
    for (const Json& task : p["tasks"])
        seconds += task["stage"] == "chain" ? double(task["seconds"]) : 0;
    EXPECT_GE(seconds, 12) << "1 s a frame of the simulation: " << p["tasks"];
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

TEST_F(Farm, VariesAVariable)
{
    std::string text = counting;
    text.replace(text.find("\"bias\": 10"), 10, "\"bias\": \"=lift\"");
    text.replace(text.find("\"nodes\""), 0, "\"variables\": { \"lift\": 10 }, ");
    folder_.write("falling.json", text);
    const Json p = plan({"--vary", "lift=1,2", "--task-seconds", "4"});
    ASSERT_EQ(p["shots"].size(), 2u);
    EXPECT_EQ(p["shots"][1]["var"], Json::array({"lift=2"}));
    EXPECT_EQ(local({"--vary", "lift=10,2", "--task-seconds", "4"}).exit, exit_missed);
    const Manifest second = read_manifest(folder_.path / "out/002/manifest.json");
    EXPECT_EQ(second.variables, (std::vector<std::string>{"lift=2"}));
    EXPECT_EQ(second.missed.size(), 1u) << "1 + 2 is not 11";
    EXPECT_TRUE(read_manifest(folder_.path / "out/001/manifest.json").missed.empty());
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

TEST_F(Farm, TasksOfThisMachineWriteWhatAPlainCookWrites)
{
    const Said said = local({"--task-seconds", "4"});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.out, "verified: 12 files of 1 cook")) << said.out;
    EXPECT_TRUE(has(said.err, "5 of 5")) << said.err;
    EXPECT_EQ(files("out"), cooked());
    EXPECT_EQ(files("out").size(), 12u);
    EXPECT_TRUE(std::filesystem::exists(folder_.path / "out/farm/plan.json"));
}

TEST_F(Farm, EachResultIsMadeOnce)
{
    toys::take_runs("Accumulate");
    toys::take_runs("WriteNumber");
    ASSERT_EQ(local({"--task-seconds", "4"}).exit, exit_ok);
    EXPECT_EQ(toys::take_runs("Accumulate"), 12);
    EXPECT_EQ(toys::take_runs("WriteNumber"), 12);
    // And a second time not at all.
    const Said again = local({});
    EXPECT_EQ(again.exit, exit_ok);
    EXPECT_TRUE(has(again.err, "1 of 1")) << again.err;
    EXPECT_EQ(toys::take_runs("WriteNumber"), 0);
}

TEST_F(Farm, ALongerShotGoesOnFromWhatAShorterOneStored)
{
    std::string text = counting;
    text.replace(text.find("\"last\": 12"), 10, "\"last\": 30");
    const std::string longer = folder_.write("longer.json", text).string();
    toys::take_runs("Accumulate");
    const Said said = local({longer, "--task-seconds", "4"});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.err, "longer.chain-sim-from-13 (frames 13-30)")) << said.err;
    EXPECT_EQ(toys::take_runs("Accumulate"), 30) << "the first 12 frames once";
    EXPECT_EQ(files("out/falling"), cooked());
    ASSERT_EQ(run({"cook", longer, "--out", (folder_.path / "plain_longer").string()}).exit,
              exit_ok);
    EXPECT_EQ(files("out/longer"), files("plain_longer"));
    EXPECT_EQ(files("out/longer").size(), 30u);
}

TEST_F(Farm, ATaskThatDiesStopsWhatDependsOnItAndNothingElse)
{
    const Said said = local({"--task-seconds", "4"}, "frames-2");
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "task falling.frames-2 (frames 5-8) was killed by signal 9 on "))
        << said.err;
    EXPECT_TRUE(has(said.err, "1 of 5 tasks failed, 1 wait for them")) << said.err;
    EXPECT_EQ(files("out").size(), 8u) << "the other frames are there";
    EXPECT_FALSE(std::filesystem::exists(folder_.path / "out/manifest.json"));

    toys::take_runs("WriteNumber");
    toys::take_runs("Accumulate");
    EXPECT_EQ(local({"--task-seconds", "4"}).exit, exit_ok);
    EXPECT_EQ(toys::take_runs("WriteNumber"), 4) << "the frames that were missing";
    EXPECT_EQ(toys::take_runs("Accumulate"), 0) << "the simulation is in the cache";
    EXPECT_EQ(files("out"), cooked());
}

TEST_F(Farm, ANodeThatFailsIsNamedWithItsFrameTaskAndMachine)
{
    std::string text = counting;
    text.replace(
        text.find(
            R"("sum": { "type": "Sum@1", "inputs": { "values": ["sim.value"] }, "params": { "bias": 10 } })"),
        std::string(
            R"("sum": { "type": "Sum@1", "inputs": { "values": ["sim.value"] }, "params": { "bias": 10 } })")
            .size(),
        R"("sum": { "type": "Fail@1", "inputs": { "value": "sim.value" }, "params": { "above": 50000 } })");
    text.replace(text.find(R"("min": 11, "max": 11)"), 20, R"("min": 0)");
    folder_.write("falling.json", text);
    // The sum over frames of frame + 1000 (frame - 1) / 24 is above 2,000 from frame 10 on.
    text.replace(text.find("50000"), 5, "1800");
    folder_.write("falling.json", text);
    const Said said = local({"--task-seconds", "4"});
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "task falling.frames-3 (frames 9-12) failed with exit code 1 on "))
        << said.err;
    EXPECT_TRUE(has(said.err, "'sum' (Fail) failed at frame 10")) << said.err;
    EXPECT_EQ(files("out").size(), 9u) << "all frames that do not fail";
}

TEST_F(Farm, AFileThatAnotherChangedIsFound)
{
    ASSERT_EQ(local({"--task-seconds", "4"}).exit, exit_ok);
    // As if it had been damaged between its task and the last one: the last one writes it again.
    folder_.write("out/7number.txt", "damaged");
    EXPECT_EQ(local({}).exit, exit_ok);
    EXPECT_EQ(files("out"), cooked());
}

TEST_F(Farm, AFileThatIsNotWhatItsTaskMadeIsAFailureThatNamesFileFrameAndMachine)
{
    const std::filesystem::path out = folder_.path / "out";
    const std::vector<std::string> status{"farm", "status", file_, "--out", out.string()};
    std::array<char, 256> host{};
    ::gethostname(host.data(), host.size() - 1);
    const std::string maker = " by task falling.frames-2 (frames 5-8) on ";
    const std::string place = "error: falling, 'write', frame 7: " + (out / "7number.txt").string();
    const std::vector<std::pair<std::string, std::function<void()>>> breaks{
        {"is not what was cooked", [&] { folder_.write("out/7number.txt", "damaged"); }},
        {"is missing that was cooked", [&] { std::filesystem::remove(out / "7number.txt"); }},
        {"is not what was cooked",
         [&] {
             std::filesystem::copy_file(out / "6number.txt", out / "7number.txt",
                                        std::filesystem::copy_options::overwrite_existing);
         }},
    };
    for (const auto& [what, break_it] : breaks) {
        ASSERT_EQ(local({"--task-seconds", "4"}).exit, exit_ok);
        break_it();
        const Said said = run(status);
        EXPECT_EQ(said.exit, exit_failed);
        EXPECT_TRUE(has(said.err, place + ' ' + what + maker + host.data() + '\n')) << said.err;
        EXPECT_TRUE(has(said.err, "the same farm command cooks what is wrong again")) << said.err;
        EXPECT_FALSE(has(said.out, "verified")) << said.out;
        // What it says that one should do does help.
        EXPECT_EQ(local({"--task-seconds", "4"}).exit, exit_ok);
        EXPECT_EQ(files("out"), cooked());
        break_it();
        const std::string again = run(status).err;
        EXPECT_TRUE(has(again, std::string(" by the last task on ") + host.data())) << again;
        std::filesystem::remove_all(folder_.path / "cache");
        std::filesystem::remove_all(out);
    }
}

TEST_F(Farm, AFileThatIsDamagedAfterTheLastTaskIsFoundBeforeSuccessIsSaid)
{
    after_task = [&](const std::string& log) {
        if (has(log, "falling.last")) folder_.write("out/7number.txt", "damaged");
    };
    const Said said = local({"--task-seconds", "4"});
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "frame 7: ") && has(said.err, "falling.frames-2")) << said.err;
    EXPECT_FALSE(has(said.out, "verified")) << said.out;
}

TEST_F(Farm, ASweepHasTheTableOfAPlainOne)
{
    const std::vector<std::string> varied{"--vary", "sum.bias=1,2,3", "--vary", "sim.start=0,5"};
    std::vector<std::string> asked{"--task-seconds", "0.01"};
    asked.insert(asked.end(), varied.begin(), varied.end());
    toys::take_runs("Accumulate");
    const Said said = local(asked);
    EXPECT_EQ(said.exit, exit_missed) << "only the bias 10 meets the expectation: " << said.err;
    EXPECT_TRUE(has(said.err, "missed: falling-005, ")) << said.err;
    EXPECT_EQ(toys::take_runs("Accumulate"), 24) << "two simulations, and none for the table";
    EXPECT_TRUE(has(said.out, "verified: 73 files of 6 cooks")) << said.out;

    std::vector<std::string> plain{"sweep", file_, "--out", (folder_.path / "plain").string()};
    plain.insert(plain.end(), varied.begin(), varied.end());
    ASSERT_EQ(run(plain).exit, exit_ok);
    const auto without_seconds = [](const std::string& text) {
        // "2","5",12,...,SECONDS,"",0,"": the fourth column from the end.
        std::string out;
        std::istringstream lines(text);
        for (std::string line; std::getline(lines, line);) {
            std::size_t end = line.size();
            for (int i = 0; i < 3; ++i) end = line.rfind(',', end - 1);
            const std::size_t begin = line.rfind(',', end - 1);
            out += line.erase(begin, end - begin) + "\n";
        }
        return out;
    };
    const std::string table = toys::bytes_of(folder_.path / "out/sweep.csv");
    EXPECT_EQ(without_seconds(table),
              without_seconds(toys::bytes_of(folder_.path / "plain/sweep.csv")));
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 7) << table;

    folder_.write("out/sweep.csv", "damaged");
    const Said status = run({"farm", "status", file_, "--out", (folder_.path / "out").string()});
    EXPECT_EQ(status.exit, exit_failed);
    EXPECT_TRUE(has(status.err, "falling.sweep: sweep.csv is not what was written")) << status.err;
}

TEST_F(Farm, ADocumentWithoutNumbersAndPicturesTakesNoTableFromOthers)
{
    // Its output is neither a picture nor a number.
    graph::Registry registry;
    registry.add("Mute", 1, Mute::run)
        .param("size", &Mute::Inputs::size, "How many.")
        .output("numbers", &Mute::Outputs::numbers, "Zeros.");
    registry.add("Slow", 1, toys::Slow::run)
        .input("value", &toys::Slow::Inputs::value, "Repeated.", graph::Need::optional)
        .param("size", &toys::Slow::Inputs::size, "How often.", {.min = 0})
        .output("numbers", &toys::Slow::Outputs::numbers, "Copies.")
        .output("first", &toys::Slow::Outputs::first, "The value.");
    std::vector<std::string> args{"farm",
                                  "--vary",
                                  "all.size=1,2",
                                  "--plan",
                                  "--json",
                                  "--cache",
                                  (folder_.path / "cache").string()};
    for (const std::string type : {"Mute", "Slow"}) {
        const std::string text =
            R"({ "aspic": 1, "nodes": { "all": { "type": ")" + type + R"(@1" } } })";
        args.push_back(folder_.write(type + ".json", text).string());
    }
    std::ostringstream out, err;
    Console console{out, err, false, {}, {}, "1.2.3"};
    ASSERT_EQ(run_command_line(args, registry, console), exit_ok) << err.str();
    std::vector<std::string> sweeps;
    const Json both = Json::parse(out.str());
    for (const Json& task : both["tasks"]) {
        if (task["stage"] == "sweep") sweeps.push_back(task["name"]);
    }
    EXPECT_EQ(sweeps, std::vector<std::string>{"Slow.sweep"});
}

TEST_F(Farm, AMissedExpectationIsToldAtTheEnd)
{
    std::string text = counting;
    text.replace(text.find("\"max\": 11"), 9, "\"max\": 99");
    text.replace(text.find("\"min\": 11"), 9, "\"min\": 50");
    folder_.write("falling.json", text);
    const Said said = local({"--task-seconds", "4"});
    EXPECT_EQ(said.exit, exit_missed) << said.err;
    EXPECT_EQ(files("out").size(), 12u);
    EXPECT_TRUE(has(said.err, "missed: falling, ")) << said.err;
    // The status tells it, too.
    const Said status = run({"farm", "status", file_, "--out", (folder_.path / "out").string()});
    EXPECT_EQ(status.exit, exit_missed) << status.out << status.err;
    EXPECT_TRUE(has(status.err, "sum.value at frame 1: expected 50 to 99, found 11")) << status.err;
}

TEST_F(Farm, ScriptsForSlurmSayWhatTheyCookAndWhatTheyWaitFor)
{
    const Said said = slurm({"--task-seconds", "4", "--threads", "3", "--sbatch=--partition=long"});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.out, "sent: 5 tasks in 3 jobs")) << said.out;
    const std::string script = job_file("jobs/falling.frames-1-to-3.sbatch");
    for (const char* const part :
         {"#SBATCH --array=1-3\n", "#SBATCH --cpus-per-task=3\n", "#SBATCH --requeue\n",
          "#SBATCH --partition=long\n", "frames=(1-4 5-8 9-12)\n", "'/opt/with space/aspic' cook ",
          "--frames \"${frames[SLURM_ARRAY_TASK_ID - 1]}\"", "/farm/parts/$task.json",
          "--threads 3"}) {
        EXPECT_TRUE(has(script, part)) << part << "\n" << script;
    }
    EXPECT_FALSE(has(script, "--mem=")) << "nothing was measured yet";
    const std::string submit = job_file("submit.sh");
    EXPECT_TRUE(has(submit, "send falling.chain-sim; j1=$id\n"
                            "send falling.frames-1-to-3 --dependency=afterok:$j1; j2=$id\n"
                            "send falling.last --dependency=afterok:$j2; j3=$id\n"))
        << submit;
}

TEST_F(Farm, NamesThatScriptsForSlurmCannotHoldAreRefused)
{
    for (const char* const name : {"my shot.json", "100%j.json", "a\nb.json"}) {
        file_ = folder_.write(name, counting).string();
        const Said said = slurm({});
        EXPECT_EQ(said.exit, exit_usage);
        EXPECT_TRUE(has(said.err, "Slurm: expected names")) << said.err;
    }
}

TEST_F(Farm, WhatAnEngineRefusesLeavesAnEarlierJobAsItWas)
{
    const auto files = [&] {
        std::vector<std::string> names;
        const std::filesystem::recursive_directory_iterator all(folder_.path / "out");
        for (const auto& entry : all) names.push_back(entry.path().string());
        std::sort(names.begin(), names.end());
        return names;
    };
    file_ = folder_.write("my {{shot.json", counting).string();
    ASSERT_EQ(local({}).exit, exit_ok);
    const auto before = files();
    EXPECT_TRUE(std::any_of(before.begin(), before.end(),
                            [](const std::string& name) { return has(name, "/logs/"); }));
    EXPECT_EQ(slurm({}).exit, exit_usage);
    EXPECT_EQ(farm({"--engine", "openjd"}).exit, exit_usage);
    EXPECT_EQ(files(), before);
}

TEST_F(Farm, SlurmIsAskedForWhatWasMeasured)
{
    ASSERT_EQ(local({"--task-seconds", "4", "--frames", "1-8"}).exit, exit_ok);
    ASSERT_EQ(slurm({"--task-seconds", "0.001"}).exit, exit_ok);
    const std::string script = job_file("jobs/falling.chain-sim.sbatch");
    EXPECT_TRUE(has(script, "#SBATCH --mem=")) << script;
    EXPECT_TRUE(has(script, "#SBATCH --time=16\n")) << script;
    EXPECT_TRUE(has(script, "--threads \"$SLURM_CPUS_PER_TASK\"")) << script;
    EXPECT_TRUE(has(job_file("measured.json"), "\"falling.chain\"")) << job_file("measured.json");
}

TEST_F(Farm, SlurmIsAskedForTheCoresThatWereBusy)
{
    const auto asked = [&](double seconds, double cores) {
        EXPECT_EQ(slurm({"--task-seconds", "4"}).exit, exit_ok);
        folder_.write("out/farm/measured.json", "{}");
        Manifest part;
        part.documents = {{file_, ""}};
        part.complete = true;
        part.ran = {"n0", seconds, 1, cores};
        folder_.write("out/farm/parts/falling.chain-sim.json", to_text(part));
        EXPECT_EQ(slurm({"--task-seconds", "4"}).exit, exit_ok);
        const std::string script = job_file("jobs/falling.chain-sim.sbatch");
        const std::size_t at = script.find("--cpus-per-task=") + 16;
        return script.substr(at, script.find('\n', at) - at);
    };
    EXPECT_EQ(asked(100, 3.4), "3");
    EXPECT_EQ(asked(100, 1.2), "1") << "one thread, and a little beside it";
    EXPECT_EQ(asked(0.01, 7.3), "1") << "cancelled while it began";
}

TEST_F(Farm, WhatSlurmSaysAgainstAJobIsShown)
{
    const Said said = slurm({}, 1);
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "could not be sent to Slurm") && has(said.err, "Invalid partition"))
        << said.err;
    EXPECT_TRUE(has(slurm({}, 127).err, "is not there: is this a machine of the farm?"));
}

TEST_F(Farm, StatusAndLogsTellOfALocalRunToo)
{
    EXPECT_EQ(run({"farm", "status", file_, "--out", (folder_.path / "out").string()}).exit,
              exit_usage)
        << "nothing was sent";
    ASSERT_EQ(local({"--task-seconds", "4"}, "frames-2").exit, exit_failed);
    folder_.write("out/farm/logs/falling.frames-2.log",
                  "task falling.frames-2 on n7, job 3\nKilled\n");
    const std::vector<std::string> where{file_, "--out", (folder_.path / "out").string()};
    const Said status = run({"farm", "status", where[0], where[1], where[2]});
    EXPECT_EQ(status.exit, exit_failed);
    EXPECT_TRUE(has(status.out, "3 of 5 tasks are done, 0 run, 0 wait, 1 failed, 1 did not run"))
        << status.out;
    EXPECT_TRUE(has(status.out, "falling.frames-2 (frames 5-8) failed on n7")) << status.out;
    EXPECT_TRUE(has(status.out, "  Killed")) << status.out;
    const Said logs = run({"farm", "logs", where[0], where[1], where[2]});
    EXPECT_TRUE(has(logs.out, "==> falling.frames-2 <==\ntask falling.frames-2 on n7")) << logs.out;
}

TEST_F(Farm, MessagesSayWhatToDo)
{
    const std::string out = (folder_.path / "out").string();
    const auto ask = [&](const std::string& what, std::vector<std::string> more = {}) {
        more.insert(more.begin(), {"farm", what, file_, "--out", out});
        return run(more);
    };
    // Of the scheduler that it was not written for.
    EXPECT_TRUE(has(farm({"--engine", "openjd", "--wait"}).err,
                    "--wait and --sbatch are for --engine slurm, found --engine openjd"));
    // Tasks that share no cache would each cook all.
    folder_.write("file", "");
    const Said no_cache = run({"farm", file_, "--engine", "openjd", "--out", out, "--cache",
                               (folder_.path / "file/cache").string()});
    EXPECT_EQ(no_cache.exit, exit_usage);
    EXPECT_TRUE(has(no_cache.err, "file/cache can't be written (Not a directory), and tasks"))
        << no_cache.err;

    ASSERT_EQ(farm({"--engine", "openjd", "--task-seconds", "4"}).exit, exit_ok);
    EXPECT_TRUE(has(ask("status").err, "nothing has run: give " + out + "/farm/job.template.json"))
        << ask("status").err;
    EXPECT_TRUE(has(ask("cancel").err, "other schedulers cancel their jobs themselves"));
    EXPECT_TRUE(has(ask("logs").err, "no task failed; --task NAME shows what any said, as --task "
                                     "falling.last\n"));
    EXPECT_TRUE(has(ask("logs", {"--task", "falling.frames-4"}).err,
                    "no task is called 'falling.frames-4'; did you mean 'falling.frames-"))
        << ask("logs", {"--task", "falling.frames-4"}).err;
    EXPECT_TRUE(has(ask("logs", {"--task", "falling.last"}).err, "falling.last did not run\n"));

    ASSERT_EQ(local({"--task-seconds", "4"}, "frames-2").exit, exit_failed);
    EXPECT_TRUE(has(ask("status").err, "the same farm command cooks what is missing"));
    folder_.write("out/farm/plan.json", "{");
    EXPECT_TRUE(has(ask("status").err, "the farm command that sent the job writes it again"));
}

TEST_F(Farm, ACacheFileThatIsDamagedBetweenTasksCostsTimeAndNothingElse)
{
    std::atomic<bool> damaged{false};
    before_task = [&](const std::string& log) {
        if (!has(log, "frames-") || damaged.exchange(true)) return;
        for (const auto& f :
             std::filesystem::recursive_directory_iterator(folder_.path / "cache")) {
            if (!f.is_regular_file() || f.file_size() < 40) continue;
            std::fstream file(f.path());
            file.seekp(static_cast<std::streamoff>(f.file_size() - 9));
            file << "damage";
        }
    };
    const Said said = local({"--task-seconds", "4", "--at-once", "1"});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(damaged);
    EXPECT_EQ(files("out"), cooked());
    EXPECT_FALSE(std::filesystem::is_empty(folder_.path / "cache/5/aside")) << "they were read";
}

TEST_F(Farm, ATemplateForOpenJobDescriptionHasAStepAJob)
{
    ASSERT_EQ(farm({"--engine", "openjd", "--task-seconds", "4", "--threads", "2"}).exit, exit_ok);
    const Json job = Json::parse(job_file("job.template.json"));
    EXPECT_EQ(job["specificationVersion"], "jobtemplate-2023-09");
    ASSERT_EQ(job["steps"].size(), 3u) << job;
    const Json& frames = job["steps"][1];
    EXPECT_EQ(frames["dependencies"], Json::array({Json{{"dependsOn", "falling.chain-sim"}}}));
    const Json& space = frames["parameterSpace"];
    EXPECT_EQ(space["combination"], "(Task, Frames)");
    EXPECT_EQ(space["taskParameterDefinitions"][1]["range"], (Json{"1-4", "5-8", "9-12"}));
    const Json& run = frames["script"]["actions"]["onRun"];
    EXPECT_TRUE(has(run["args"].dump(), "\"--frames\",\"{{Task.Param.Frames}}\"")) << run;
    EXPECT_TRUE(has(run["args"].dump(), "/parts/{{Task.Param.Task}}.json")) << run;
    EXPECT_EQ(frames["hostRequirements"]["amounts"][0]["min"], 2);
    EXPECT_FALSE(job["steps"][2].contains("parameterSpace")) << "one task";
}

TEST_F(Farm, ThreadsLimitThoseOfLibrariesToo)
{
    const auto told = [&](std::vector<std::string> more) {
        int threads = -1;
        std::ostringstream out, err;
        Console console{out, err, false, {}, {}, "1.2.3"};
        console.limit_libraries = [&](int n) { threads = n; };
        more.insert(more.begin(),
                    {"cook", file_, "--no-disk-cache", "--out", (folder_.path / "out").string()});
        EXPECT_EQ(run_command_line(more, toys::registry(), console), exit_ok) << err.str();
        return threads;
    };
    EXPECT_EQ(told({"--threads", "1"}), 1);
    EXPECT_EQ(told({"--threads", "3"}), 3);
    EXPECT_EQ(told({}), -1) << "as they like";
}

TEST_F(Farm, ACookTellsOpenJobDescriptionHowFarItIs)
{
    const Said said = run({"cook", file_, "--out", (folder_.path / "out").string(), "--openjd"});
    EXPECT_EQ(said.exit, exit_ok);
    EXPECT_TRUE(has(said.out, "openjd_progress: 100.0\nopenjd_status: 13 of 13 results\n"))
        << said.out;
    const Said missed = run({"cook", file_, "--out", (folder_.path / "out").string(), "--openjd",
                             "--set", "sum.bias=11"});
    EXPECT_EQ(missed.exit, exit_missed);
    EXPECT_TRUE(has(missed.out, "openjd_fail: an expectation was missed")) << missed.out;
    const Said failed = run({"cook",
                             folder_
                                 .write("fail.json", R"({ "aspic": 1, "nodes": {
                                 "one": { "type": "Constant@1" },
                                 "bad": { "type": "Fail@1", "inputs": { "value": "one.value" } },
                                 "write": { "type": "WriteNumber@1",
                                            "inputs": { "value": "bad.value" } } } })")
                                 .string(),
                             "--out", (folder_.path / "out").string(), "--openjd"});
    EXPECT_EQ(failed.exit, exit_failed);
    EXPECT_TRUE(has(failed.out, "openjd_fail: ") && has(failed.out, "'bad' (Fail) failed"))
        << failed.out;
}
