#include "runtime/commands/sweep.hpp"

#include "runtime/commands/manifest.hpp"
#include "runtime/commands/sweep_command.hpp"
#include "tests/runtime/said.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace runtime;
using toys::has;
using toys::run;
using toys::Said;

namespace {

const char* const document = R"({ "aspic": 1, "frames": { "first": 1, "last": 3 }, "nodes": {
    "base": { "type": "Constant@1", "params": { "value": 5 } },
    "slow": { "type": "Slow@1", "inputs": { "value": "base.value" },
              "params": { "seconds": 0.001 } },
    "a": { "type": "Sum@1", "inputs": { "values": ["slow.first"] } },
    "b": { "type": "Fail@1", "inputs": { "value": "a.value" }, "params": { "above": 100 } } } })";

SweepOptions varying(const std::vector<const char*>& what)
{
    SweepOptions options;
    for (const char* text : what) options.varied.push_back(parse_vary(text));
    return options;
}

std::vector<std::string> lines_of(const std::filesystem::path& file)
{
    std::ifstream in(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

}  // namespace

TEST(Sweep, EveryCombinationIsCookedAndWhatIsEqualOnce)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    Caches caches;
    toys::take_runs("Slow");
    const Swept swept =
        sweep(file, toys::registry(), varying({"base.value=5,6", "a.bias=1,2,3"}), caches);
    ASSERT_EQ(swept.rows.size(), 6u);
    EXPECT_EQ(toys::take_runs("Slow"), 2) << "once a base";
    ASSERT_EQ(swept.measures,
              (std::vector<std::string>{"base.value", "slow.first", "a.value", "b.value"}));
    for (std::size_t i = 0; i < 6; ++i) {
        // The last one varies fastest: 5+1, 5+2, 5+3, 6+1 ...
        const std::size_t slow = i / 3, fast = i % 3;
        EXPECT_EQ(swept.rows[i].numbers[2], 5 + double(slow) + 1 + double(fast));
        EXPECT_EQ(swept.rows[i].failure, "");
        EXPECT_FALSE(swept.rows[i].picture);
    }
}

TEST(Sweep, AFailedCombinationIsDataAndTheOthersGoOn)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    Caches caches;
    const Swept swept = sweep(file, toys::registry(), varying({"a.bias=1,1000,2,\"x\""}), caches);
    ASSERT_EQ(swept.rows.size(), 4u);
    EXPECT_EQ(swept.rows[0].failure, "");
    EXPECT_TRUE(has(swept.rows[1].failure, "value 1005 is too large")) << swept.rows[1].failure;
    EXPECT_EQ(swept.rows[1].numbers[2], 1005) << "what could be made is there";
    EXPECT_TRUE(std::isnan(swept.rows[1].numbers[3]));
    EXPECT_EQ(swept.rows[2].numbers[3], 7);
    EXPECT_TRUE(has(swept.rows[3].failure, "expected a number")) << swept.rows[3].failure;
    const std::string csv = to_csv(swept);
    EXPECT_TRUE(csv.starts_with("\"a.bias\",frame,\"base.value\",")) << csv;
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5) << "a line each: " << csv;
}

TEST(Sweep, ACombinationThatDoesNotLoadIsALineWhereverItStands)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    Caches caches;
    const Swept swept = sweep(file, toys::registry(), varying({"a.bias=\"x\",1,\"y\",2"}), caches);
    ASSERT_EQ(swept.rows.size(), 4u);
    for (const std::size_t i : {0u, 2u}) {
        EXPECT_TRUE(has(swept.rows[i].failure, "expected a number")) << swept.rows[i].failure;
    }
    EXPECT_EQ(swept.rows[1].numbers[2], 6);
    EXPECT_EQ(swept.rows[3].numbers[2], 7);
    const auto out = (folder.path / "out").string();
    const Said said = run({"sweep", file, "--vary", "a.bias=\"x\",1", "--out", out});
    EXPECT_EQ(said.exit, exit_failed) << said.err;
    EXPECT_EQ(lines_of(folder.path / "out/sweep.csv").size(), 3u);
    // Of none that loads nothing is known, not even what would be looked at.
    const Said none = run({"sweep", file, "--vary", "a.bias=\"x\",\"y\"", "--out", out});
    EXPECT_EQ(none.exit, exit_usage);
    EXPECT_TRUE(has(none.err, "expected a number")) << none.err;
}

// Of a document, and of a shot that extends it; before what --var says.
TEST(Sweep, VariesAVariable)
{
    const toys::Folder folder;
    const auto base = folder.write("base.json", R"({ "aspic": 1,
      "variables": { "lift": 1, "twice": "=2 * lift" }, "nodes": {
        "base": { "type": "Constant@1", "params": { "value": 5 } },
        "a": { "type": "Sum@1", "inputs": { "values": ["base.value"] },
               "params": { "bias": "=twice" } } } })");
    const auto shot = folder.write("shot.json", R"({ "aspic": 1, "extends": "base.json",
      "nodes": { "base": { "params": { "value": 6 } } } })");
    const auto out = folder.path / "out";
    for (const auto& [file, value] : {std::pair(base, 5), std::pair(shot, 6)}) {
        const Said said = run({"sweep", file, "--vary", "lift=10,0.5", "--var", "lift=3",
                               "--measure", "a.value", "--out", out});
        EXPECT_EQ(said.exit, exit_ok) << said.err;
        EXPECT_TRUE(has(said.err, "lift=10: done")) << said.err;
        const std::vector<std::string> lines = lines_of(out / "sweep.csv");
        ASSERT_EQ(lines.size(), 3u);
        EXPECT_TRUE(lines[0].starts_with("\"lift\",frame,\"a.value\"")) << lines[0];
        EXPECT_TRUE(lines[1].starts_with(fmt::format("\"10\",1,{},", value + 20))) << lines[1];
        EXPECT_TRUE(lines[2].starts_with(fmt::format("\"0.5\",1,{},", value + 1))) << lines[2];
    }
    const Said near = run({"sweep", base, "--vary", "lfit=1,2", "--out", out});
    EXPECT_EQ(near.exit, exit_usage);
    EXPECT_TRUE(has(near.err, "the document declares no variable 'lfit'")) << near.err;
    EXPECT_TRUE(has(near.err, "did you mean 'lift'?")) << near.err;
    const Said text = run({"sweep", base, "--vary", "lift=much,more", "--out", out});
    EXPECT_EQ(text.exit, exit_usage);
    EXPECT_TRUE(has(text.err, "expected name=number, found 'lift=much'")) << text.err;
}

TEST(Sweep, ACancelledOneLeavesTheTableOfAnEarlierOne)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    const auto out = folder.path / "out", part = folder.path / "part.json";
    const std::vector<std::string> args{"sweep", file, "--vary", "a.bias=1,2",
                                        "--out", out,  "--part", part};
    EXPECT_EQ(run(args).exit, exit_ok);
    const std::string before = toys::bytes_of(out / "sweep.csv");
    EXPECT_NE(before, "");
    EXPECT_TRUE(read_manifest(part).complete);
    std::stop_source source;
    source.request_stop();
    const Said said = run(args, source.get_token());
    EXPECT_EQ(said.exit, exit_cancelled) << said.err;
    EXPECT_EQ(toys::bytes_of(out / "sweep.csv"), before);
    EXPECT_EQ(said.out, "") << "no table is told";
    EXPECT_FALSE(read_manifest(part).complete) << "the farm is told";
}

TEST(Sweep, SeveralFramesAreARowEach)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", R"({ "aspic": 1, "frames": { "last": 9 }, "nodes": {
        "still": { "type": "Constant@1" },
        "clock": { "type": "Clock@1" },
        "sum": { "type": "Sum@1", "inputs": { "values": ["still.value", "clock.value"] } } } })");
    Caches caches;
    SweepOptions options = varying({"sum.bias=0,10"});
    options.frames = {1, 7};
    options.measures = {"still.value", "sum.value"};
    const Swept swept = sweep(file, toys::registry(), options, caches);
    ASSERT_EQ(swept.rows.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        const int frame = i % 2 == 0 ? 1 : 7;
        EXPECT_EQ(swept.rows[i].frame, frame);
        EXPECT_EQ(swept.rows[i].numbers[0], 1) << "the same at all frames, and in all rows";
        EXPECT_EQ(swept.rows[i].numbers[1],
                  1 + frame + 1000 * ((frame - 1) / 24.0) + (i < 2 ? 0 : 10));
    }
    const Said said = run({"sweep", file, "--vary", "sum.bias=1,2", "--frames", "1-9x4", "--out",
                           (folder.path / "out").string()});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_EQ(lines_of(folder.path / "out/sweep.csv").size(), 7u);
    EXPECT_TRUE(has(said.err, "frame 5")) << said.err;
}

TEST(Sweep, AFailureIsReportedForEachFrameThatItAffects)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", R"({ "aspic": 1, "frames": { "last": 9 }, "nodes": {
        "clock": { "type": "Clock@1" },
        "early": { "type": "Fail@1", "inputs": { "value": "clock.value" },
                   "params": { "above": 150 } } } })");  // 167 + 5 at frame 5
    Caches caches;
    SweepOptions options = varying({"early.above=150,1000"});
    options.frames = {1, 4, 5, 9};
    const Swept swept = sweep(file, toys::registry(), options, caches);
    ASSERT_EQ(swept.rows.size(), 8u);
    for (const SweepRow& row : swept.rows) {
        const bool fails = row.frame >= 5 && row.settings[0].value == "150";
        EXPECT_EQ(std::isnan(row.numbers[1]), fails) << row.frame;
        EXPECT_EQ(row.failure.empty(), !fails) << row.frame << ": " << row.failure;
        const std::string at = "at frame " + std::to_string(row.frame);
        EXPECT_TRUE(!fails || has(row.failure, at)) << row.failure;
    }
}

TEST(Sweep, OptionsThatMakeNoSenseAreRefused)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    const auto refused = [&](const SweepOptions& options) -> std::string {
        Caches caches;
        try {
            static_cast<void>(sweep(file, toys::registry(), options, caches));
        } catch (const std::invalid_argument& e) {
            return e.what();
        }
        return "";
    };
    SweepOptions o = varying({"a.bias=1"});
    o.measures = {"a.valeu"};
    EXPECT_TRUE(has(refused(o), "expected an output node.port")) << refused(o);
    o.measures = {"slow.numbers"};
    EXPECT_TRUE(has(refused(o), "to be a number")) << refused(o);
    o.measures = {}, o.frames = {1, 7};
    EXPECT_TRUE(has(refused(o), "frames 1 to 3; frame 7")) << refused(o);
    o.frames = {}, o.picture = "b";
    EXPECT_TRUE(has(refused(o), "to be a picture")) << refused(o);
    EXPECT_TRUE(has(refused(varying({"nobody.bias=1"})), "nobody"));
}

TEST(Sweep, TheCommandLeavesATableAndASheet)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    const auto out = (folder.path / "out").string();
    const Said said =
        run({"sweep", file, "--vary", "a.bias=1,2", "--measure", "b.value", "--out", out});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    const std::vector<std::string> lines = lines_of(folder.path / "out/sweep.csv");
    ASSERT_EQ(lines.size(), 3u);
    EXPECT_EQ(lines[0], "\"a.bias\",frame,\"b.value\",seconds,failure,warnings,first_warning");
    EXPECT_TRUE(lines[1].starts_with("\"1\",3,6,")) << lines[1];
    EXPECT_TRUE(lines[2].starts_with("\"2\",3,7,")) << lines[2];
    EXPECT_TRUE(has(said.out, "table: " + out)) << said.out;
    EXPECT_EQ(run({"sweep", file, "--vary", "a.bias=1000", "--out", out}).exit, exit_failed);
    EXPECT_EQ(run({"sweep", file, "--out", out}).exit, exit_usage) << "vary what?";
    EXPECT_EQ(run({"sweep", file, "--vary", "a.bias", "--out", out}).exit, exit_usage);
}

TEST(Sweep, TheCommandRemembersAsMuchAsItMay)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", document);
    const auto runs_with = [&](const char* memory) {
        toys::take_runs("Slow");
        const Said said = run({"sweep", file, "--vary", "a.bias=1,2,3", "--no-disk-cache",
                               "--memory", memory, "--out", (folder.path / "out").string()});
        EXPECT_EQ(said.exit, exit_ok) << said.err;
        return toys::take_runs("Slow");
    };
    EXPECT_EQ(runs_with("1G"), 1);
    EXPECT_EQ(runs_with("1"), 3) << "no result fits";
}

TEST(Sweep, WarningsAreCountedForEachSettingAndShownOnce)
{
    const toys::Folder folder;
    const auto file = folder.write("s.json", R"({ "aspic": 1, "frames": { "last": 3 }, "nodes": {
        "clock": { "type": "Clock@1" },
        "loud": { "type": "Warns@1", "inputs": { "value": "clock.value" },
                  "params": { "above": 0, "text": "this is much" } } } })");
    const auto out = (folder.path / "out").string();
    const Said said =
        run({"sweep", file, "--vary", "loud.above=0,1,1e9", "--frames", "1,3", "--out", out});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    const auto first = said.err.find("  warning: 'loud': this is much\n");
    EXPECT_NE(first, std::string::npos) << said.err;
    EXPECT_EQ(first, said.err.rfind("  warning: 'loud'")) << said.err;
    EXPECT_TRUE(has(said.err, "loud.above=1, frame 3: done, 1 warning\n")) << said.err;
    EXPECT_TRUE(has(said.err, "loud.above=1e9, frame 3: done\n")) << said.err;
    const std::vector<std::string> lines = lines_of(folder.path / "out/sweep.csv");
    ASSERT_EQ(lines.size(), 7u);
    EXPECT_TRUE(lines[3].ends_with(",\"\",1,\"'loud': this is much\"")) << lines[3];
    EXPECT_TRUE(lines[6].ends_with(",\"\",0,\"\"")) << lines[6];
}
