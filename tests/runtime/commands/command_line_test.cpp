#include "runtime/commands/command_line.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/front_end.hpp"
#include "runtime/commands/text_file.hpp"
#include "tests/runtime/said.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <regex>
#include <sys/file.h>
#include <sys/fsuid.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace runtime;
using toys::has;
using toys::run;
using toys::Said;
using toys::three_frames;

TEST(Frames, ListsRangesAndStepsAreReadInOrderWithoutDoubles)
{
    EXPECT_EQ(parse_frames("7"), (std::vector<int>{7}));
    EXPECT_EQ(parse_frames("1-4"), (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(parse_frames("1-8x3"), (std::vector<int>{1, 4, 7}));
    EXPECT_EQ(parse_frames("20,10,9-11"), (std::vector<int>{9, 10, 11, 20}));
    EXPECT_EQ(parse_frames("-2-1"), (std::vector<int>{-2, -1, 0, 1}));
}

TEST(Frames, AnythingElseIsRefused)
{
    for (const char* bad : {"", "a", "1-", "4-1", "1-4x0", "1-4x", "1,", "1;2", "1-2000000000",
                            "99999999999", "1 2"}) {
        EXPECT_THROW(parse_frames(bad), std::invalid_argument) << bad;
    }
    try {
        parse_frames("9-1");
    } catch (const std::invalid_argument& error) {
        EXPECT_STREQ(error.what(), "frames '9-1' end before they begin; use 1-9");
    }
}

TEST(Bytes, SuffixesArePowersOf1024)
{
    EXPECT_EQ(parse_bytes("4096"), 4096u);
    EXPECT_EQ(parse_bytes("2K"), 2048u);
    EXPECT_EQ(parse_bytes("1.5g"), std::size_t{3} << 29);
    EXPECT_EQ(parse_bytes("3MB"), std::size_t{3} << 20);
    for (const char* bad : {"", "G", "-1", "2X", "1e40T", "nan"}) {
        EXPECT_THROW(parse_bytes(bad), std::invalid_argument) << bad;
    }
    EXPECT_EQ(format_bytes(1536), "1.5 kB");
    EXPECT_EQ(format_bytes(12), "12 B");
    EXPECT_EQ(format_bytes(std::pow(2.0, 34)), "16 GB");
}

TEST(FileGroups, ManyNumberedFilesAreOneLine)
{
    EXPECT_EQ(group_files({"out/f.0001.png", "out/f.0002.png", "out/clip.mp4"}),
              (std::vector<std::string>{"out/clip.mp4", "out/f.####.png (2 files)"}));
    EXPECT_TRUE(group_files({}).empty());
}

TEST(CommandLine, CookWritesFilesChecksExpectationsAndSaysWhereTheyAre)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto out = (folder.path / "out").string();
    const Said said = run({"cook", file, "--out", out});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.out, "write: " + out + "/#number.txt (3 files)")) << said.out;
    EXPECT_TRUE(has(said.err, "all 1 expectation met")) << said.err;
    EXPECT_TRUE(std::filesystem::exists(folder.path / "out/3number.txt"));
}

TEST(CommandLine, AMissedExpectationIsExit3AndSaysWhatWasFound)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const Said said = run({"check", file, "--set", "sum.bias=4"});
    EXPECT_EQ(said.exit, exit_missed);
    EXPECT_TRUE(has(said.err, "sum.value at frame 1: expected 11 to 11, found 5 (10 + 1)"))
        << said.err;
}

TEST(CommandLine, TwoCooksIntoOneFolderGiveAWarning)
{
    const toys::Folder folder;
    const std::string file = folder.write("three.json", three_frames).string();
    const std::string out = (folder.path / "out").string();
    EXPECT_EQ(run({"cook", file, "--out", out}).err.find("another cook"), std::string::npos);
    const int other = ::open(out.c_str(), O_RDONLY | O_DIRECTORY);
    ASSERT_EQ(::flock(other, LOCK_EX), 0);
    const Said said = run({"cook", file, "--out", out});
    ::close(other);
    EXPECT_EQ(said.exit, exit_ok);
    EXPECT_TRUE(has(said.err, "another cook is writing into " + out)) << said.err;
    EXPECT_EQ(run({"cook", file, "--out", out}).err.find("another cook"), std::string::npos);
}

TEST(CommandLine, DocumentsOfOneNameAreRefusedBeforeTheyWriteIntoOneFolder)
{
    const toys::Folder folder;
    const std::string a = folder.write("a/shot.json", three_frames).string();
    const std::string b = folder.write("b/shot.json", three_frames).string();
    const std::string out = (folder.path / "out").string();
    const Said said = run({"cook", a, b, "--out", out});
    EXPECT_EQ(said.exit, exit_usage);
    EXPECT_TRUE(has(said.err, a + " and " + b + " would write into one folder, " + out + "/shot: " +
                                  "cook them one at a time, each with its own --out DIR"))
        << said.err;
    EXPECT_FALSE(std::filesystem::exists(out));
    EXPECT_EQ(run({"check", a, b}).exit, exit_ok) << "it writes no files";
    EXPECT_EQ(run({"cook", a, a, "--out", out}).exit, exit_ok) << "one document, named twice";
}

TEST(CommandLine, CheckWritesNoFile)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    toys::take_runs("WriteNumber");
    EXPECT_EQ(run({"check", file}).exit, exit_ok);
    EXPECT_EQ(toys::take_runs("WriteNumber"), 0);
}

TEST(CommandLine, ACookThatWritesNothingIsTold)
{
    const toys::Folder folder;
    const auto cook = [&](const char* rest, std::vector<std::string> more = {}) {
        const auto file = folder.write(
            "nothing.json",
            std::string(R"({ "aspic": 1, "nodes": { "clock": { "type": "Clock@1" } })") + rest);
        more.insert(more.begin(),
                    {"cook", file, "--out", (folder.path / "out").string(), "--quiet"});
        return run(std::move(more)).err;
    };
    EXPECT_TRUE(has(cook("}"), "no node writes a file: add WriteMesh")) << cook("}");
    EXPECT_EQ(cook("}", {"--node", "clock"}), "");
    EXPECT_EQ(cook(R"(, "expect": [ { "value": "clock.value", "min": 0 } ] })"), "");
}

TEST(CommandLine, TheManifestIsNoNodesFile)
{
    const toys::Folder folder;
    const auto file = folder.write("m.json", R"({ "aspic": 1, "nodes": {
        "clock": { "type": "Clock@1" },
        "w": { "type": "WriteRow@1", "inputs": { "value": "clock" },
               "params": { "path": "manifest.json" } } } })");
    for (const char* command : {"cook", "validate"}) {
        const Said said = run({command, file});
        EXPECT_EQ(said.exit, exit_usage);
        EXPECT_TRUE(has(said.err, "manifest.json is written by the cook itself")) << said.err;
    }
}

TEST(CommandLine, FramesAndNodesChooseWhatIsCooked)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto out = (folder.path / "out").string();
    EXPECT_EQ(run({"cook", file, "--out", out, "--frames", "2"}).exit, exit_ok);
    EXPECT_FALSE(std::filesystem::exists(folder.path / "out/1number.txt"));
    EXPECT_TRUE(std::filesystem::exists(folder.path / "out/2number.txt"));
    toys::take_runs("WriteNumber");
    EXPECT_EQ(run({"cook", file, "--out", out, "--node", "sum"}).exit, exit_ok);
    EXPECT_EQ(toys::take_runs("WriteNumber"), 0);
}

TEST(CommandLine, NumbersOfANamedNodeArePrinted)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto out = (folder.path / "out").string();
    const Said said = run({"cook", file, "--out", out, "--node", "sum", "--quiet"});
    EXPECT_EQ(said.out, "sum.value at frame 1: 11\nsum.value at frame 2: 53.6667\n"
                        "sum.value at frame 3: 96.3333\n");
    const Said json = run({"cook", file, "--out", out, "--node", "sum", "--json"});
    EXPECT_TRUE(has(json.out, R"({"event":"number","value":"sum.value","frame":1,"found":11.0})"))
        << json.out;
    EXPECT_EQ(run({"cook", file, "--out", out, "--quiet"}).out, "") << "sinks give no numbers";
}

TEST(CommandLine, NumbersOfANamedNodeGoIntoATableThatTheCacheLeavesWhole)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto out = (folder.path / "out").string(), cache = (folder.path / "cache").string();
    const std::string table = "frame,seconds,sum\n1,0,11\n2,0.0416666667,53.666666666666664\n"
                              "3,0.0833333333,96.33333333333333\n";
    const auto written = [&] { return runtime::read_text(folder.path / "out/values.csv"); };
    const std::vector<std::string> words{"cook",   file,  "--out",   out,
                                         "--node", "sum", "--cache", cache};
    const Said said = run(words);
    EXPECT_TRUE(has(said.err, "values.csv (3 frames)")) << said.err;
    EXPECT_EQ(written(), table);
    std::filesystem::remove(folder.path / "out/values.csv");
    toys::take_runs("Sum");
    run(words);
    EXPECT_EQ(written(), table);
    EXPECT_EQ(run({"cook", file, "--out", out, "--values", "--frames", "2-3"}).out.find("at frame"),
              std::string::npos);
    EXPECT_EQ(written(), "frame,seconds,clock,sum\n2,0.0416666667,43.666666666666664,"
                         "53.666666666666664\n3,0.0833333333,86.33333333333333,"
                         "96.33333333333333\n");
    EXPECT_TRUE(std::filesystem::exists(folder.path / "out/2number.txt"));  // and what sinks write
    std::filesystem::remove(folder.path / "out/values.csv");
    EXPECT_EQ(run({"cook", file, "--out", out}).exit, exit_ok);
    EXPECT_FALSE(std::filesystem::exists(folder.path / "out/values.csv"));
}

// An old table beside new frames would pass for theirs.
TEST(CommandLine, ATableOfAnEarlierCookDoesNotStay)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto out = (folder.path / "out").string();
    const auto table = folder.path / "out/values.csv";
    const auto old = [&] {
        return std::filesystem::exists(folder.write("out/values.csv", "frame,seconds,old\n"));
    };
    ASSERT_TRUE(old());
    EXPECT_EQ(run({"cook", file, "--out", out}).exit, exit_ok);
    EXPECT_FALSE(std::filesystem::exists(table)) << "cooked without --values";
    ASSERT_TRUE(old());
    std::stop_source source;
    source.request_stop();
    run({"cook", file, "--out", out, "--values"}, source.get_token());
    EXPECT_FALSE(std::filesystem::exists(table)) << "cancelled";
    ASSERT_TRUE(old());
    run({"cook", file, "--out", out, "--part", (folder.path / "part.json").string()});
    EXPECT_TRUE(std::filesystem::exists(table)) << "a part of a cook leaves it to the whole";
}

TEST(CommandLine, FilesThatNoCookWroteStay)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto out = (folder.path / "out").string();
    const auto holds = [&](const char* name, const char* text) {
        return runtime::read_text(folder.path / "out" / name) == text;
    };
    const std::string mine = "was not written by a cook, and this cook would replace it; move it, "
                             "or use --out DIR";
    folder.write("out/values.csv", "my data");
    EXPECT_EQ(run({"cook", file, "--out", out}).exit, exit_ok) << "it writes no table";
    EXPECT_TRUE(holds("values.csv", "my data"));
    const Said table = run({"cook", file, "--out", out, "--values"});
    EXPECT_NE(table.exit, exit_ok);
    EXPECT_TRUE(has(table.err, "values.csv " + mine)) << table.err;
    EXPECT_TRUE(holds("values.csv", "my data"));

    folder.write("out/manifest.json", R"({ "name": "my page" })");
    const Said said = run({"cook", file, "--out", out});
    EXPECT_NE(said.exit, exit_ok);
    EXPECT_TRUE(has(said.err, "manifest.json " + mine)) << said.err;
    EXPECT_TRUE(holds("manifest.json", R"({ "name": "my page" })"));
}

TEST(CommandLine, WhereANodeFailedNothingStandsInTheTable)
{
    const toys::Folder folder;
    // Of frames 1, 2 and 3 the clock tells 1, 43.67 and 86.33.
    const auto file = folder.write("fails.json", R"({ "aspic": 1,
        "frames": { "first": 1, "last": 3 }, "nodes": {
        "clock": { "type": "Clock@1" },
        "late": { "type": "Fail@1", "inputs": { "value": "clock.value" },
                  "params": { "above": 50 } },
        "never": { "type": "Fail@1", "inputs": { "value": "clock.value" },
                   "params": { "above": 0 } } } })");
    const auto out = (folder.path / "out").string();
    const Said said = run({"cook", file, "--out", out, "--keep-going", "--node", "never", "--node",
                           "late", "--node", "clock"});
    EXPECT_EQ(said.exit, exit_failed) << said.err;
    EXPECT_EQ(runtime::read_text(folder.path / "out/values.csv"),
              "frame,seconds,clock,late,never\n1,0,1,1,\n"
              "2,0.0416666667,43.666666666666664,43.666666666666664,\n"
              "3,0.0833333333,86.33333333333333,,\n");
}

TEST(CommandLine, UnknownNamesGetTheNearestName)
{
    EXPECT_TRUE(has(run({"cok"}).err, "did you mean 'cook'?"));
    EXPECT_TRUE(has(run({"cook", "x.json", "--frame", "2"}).err, "did you mean '--frames'?"));
    EXPECT_EQ(run({"cok"}).exit, exit_usage);
    EXPECT_EQ(run({}).exit, exit_usage);
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const Said node = run({"cook", file, "--node", "smu"});
    EXPECT_EQ(node.exit, exit_usage);
    EXPECT_TRUE(has(node.err, "did you mean 'sum'?")) << node.err;
    EXPECT_EQ(run({"cook", file, "--frames", "9"}).exit, exit_usage);
    EXPECT_EQ(run({"cook", file, "--frames", "x"}).exit, exit_usage);
    const Said no_frames = run({"cook", file, "--frames", ""});
    EXPECT_EQ(no_frames.exit, exit_usage);
    EXPECT_TRUE(has(no_frames.err, "expected frames like 1-48")) << no_frames.err;
    EXPECT_EQ(run({"cook", file, "--memory", "lots"}).exit, exit_usage);
    EXPECT_EQ(run({"cook", file, "--set", "sum"}).exit, exit_usage);
    for (const char* wrong : {"a=b", "a", "a=", "=1", "a=1,5", "a=0x10"}) {
        const Said said = run({"cook", file, "--var", wrong});
        EXPECT_EQ(said.exit, exit_usage) << wrong;
        EXPECT_TRUE(has(said.err, "expected name=number")) << said.err;
    }
    for (const char* beyond : {"a=1e400", "a=-1e400", "a=1e-400", "a=inf", "a=nan"}) {
        const Said said = run({"cook", file, "--var", beyond});
        EXPECT_EQ(said.exit, exit_usage) << beyond;
        EXPECT_TRUE(has(said.err, "expected a number between")) << said.err;
    }
    EXPECT_EQ(run({"cook", (folder.path / "none.json").string()}).exit, exit_usage);
}

TEST(CommandLine, HelpAndVersionGoToTheOutput)
{
    const Said help = run({"--help"});
    EXPECT_EQ(help.exit, exit_ok);
    EXPECT_TRUE(has(help.out, "Examples:")) << help.out;
    EXPECT_TRUE(has(run({"--version"}).out, "1.2.3"));
    EXPECT_TRUE(has(run({"cook", "--help"}).out, "--keep-going"));
}

// "All met" would hide those whose number could not be made.
TEST(CommandLine, ExpectationsThatCouldNotBeCheckedAreCounted)
{
    const toys::Folder folder;
    const auto file = folder.write("bad.json", R"({ "aspic": 1, "frames": { "last": 4 },
      "nodes": {
        "clock": { "type": "Clock@1" },
        "bad": { "type": "Fail@1", "inputs": { "value": "clock.value" }, "params": { "above": 100 } } },
      "expect": [{ "value": "bad.value", "frame": "every", "max": 900 },
                 { "value": "clock.value", "frame": 2, "max": 1 }] })");
    const Said said = run({"check", file});
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "1 of 5 expectations missed, 1 could not be checked")) << said.err;
    const Said other = run({"check", file, "--set", "bad.above=1"});
    EXPECT_TRUE(has(other.err, "3 could not be checked")) << other.err;
    const Said lines = run({"check", file, "--json"});
    EXPECT_TRUE(has(lines.err + lines.out, "\"expectations_left_out\"")) << lines.err << lines.out;
}

TEST(CommandLine, AFailureIsExit1AndKeepGoingCooksTheRest)
{
    const toys::Folder folder;
    const auto file = folder.write("bad.json", R"({ "aspic": 1, "frames": { "last": 4 },
      "nodes": {
        "clock": { "type": "Clock@1" },
        "bad": { "type": "Fail@1", "inputs": { "value": "clock.value" }, "params": { "above": -1 } },
        "a": { "type": "WriteNumber@1", "inputs": { "value": "bad.value" } },
        "b": { "type": "WriteNumber@1", "inputs": { "value": "clock.value" },
               "params": { "path": "b.txt" } } } })");
    const auto out = (folder.path / "out").string();
    const Said said = run({"cook", file, "--out", out, "--keep-going"});
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "bad.json:4:")) << "the node's place: " << said.err;
    EXPECT_TRUE(has(said.err, "'bad' (Fail) failed at frame 1: value 1 is too large")) << said.err;
    EXPECT_TRUE(std::filesystem::exists(folder.path / "out/4b.txt"));
    EXPECT_EQ(run({"cook", file, "--out", out}).exit, exit_failed);
}

TEST(CommandLine, TheExitCodeOfSeveralDocumentsIsThatOfTheWorst)
{
    const toys::Folder folder;
    const auto one = [&](const char* name, const char* above, const char* min) {
        return folder
            .write(name, fmt::format(R"({{ "aspic": 1, "nodes": {{
            "clock": {{ "type": "Clock@1" }},
            "bad": {{ "type": "Fail@1", "inputs": {{ "value": "clock.value" }},
                      "params": {{ "above": {} }} }} }},
            "expect": [ {{ "value": "bad.value", "frame": 1, "min": {} }} ] }})",
                                     above, min))
            .string();
    };
    const std::string fails = one("fails.json", "-1", "0"), misses = one("misses.json", "9", "5"),
                      meets = one("meets.json", "9", "0");
    EXPECT_EQ(run({"check", misses, meets}).exit, exit_missed);
    for (const auto& files :
         {std::vector{fails, misses, meets}, {misses, fails, meets}, {meets, misses, fails}}) {
        std::vector<std::string> words{"check"};
        words.insert(words.end(), files.begin(), files.end());
        const Said said = run(words);
        EXPECT_EQ(said.exit, exit_failed);
        EXPECT_TRUE(has(said.err, "expected")) << "all are checked: " << said.err;
        words[0] = "cook";
        words.insert(words.end(), {"--out", (folder.path / "out").string(), "--keep-going"});
        EXPECT_EQ(run(words).exit, exit_failed);
    }
}

TEST(CommandLine, ValidateReportsEveryMistakeOfEveryFile)
{
    const toys::Folder folder;
    const auto good = folder.write("good.json", three_frames);
    const auto bad = folder.write("bad.json", R"({ "aspic": 1, "nodes": {
        "a": { "type": "Sun@1" }, "b": { "type": "Sum@1", "params": { "bais": 1 } } } })");
    const Said said = run({"validate", good, bad});
    EXPECT_EQ(said.exit, exit_usage);
    EXPECT_TRUE(has(said.err, "did you mean 'Sum'?")) << said.err;
    EXPECT_TRUE(has(said.err, "did you mean 'bias'?")) << said.err;
    EXPECT_TRUE(has(said.out, "good.json: valid")) << said.out;
}

TEST(CommandLine, JsonLinesAreEachOneObject)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const Said said = run({"cook", file, "--out", (folder.path / "out").string(), "--json"});
    EXPECT_EQ(said.err, "");
    std::istringstream lines(said.out);
    std::map<std::string, int> events;
    for (std::string line; std::getline(lines, line);) {
        const auto json = nlohmann::json::parse(line);
        ++events[json.at("event")];
    }
    EXPECT_EQ(
        events,
        (std::map<std::string, int>{
            {"began", 1}, {"progress", 4}, {"wrote", 3}, {"expectation", 1}, {"finished", 1}}));
}

TEST(CommandLine, QuietPrintsNothingOnSuccess)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const Said said = run({"cook", file, "--out", (folder.path / "out").string(), "--quiet"});
    EXPECT_EQ(said.out + said.err, "");
}

TEST(CommandLine, ACookThatWasStoppedIsExit130)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    std::stop_source source;
    source.request_stop();
    EXPECT_EQ(run({"cook", file, "--out", (folder.path / "out").string()}, source.get_token()).exit,
              exit_cancelled);
}

TEST(CommandLine, ManyShotsShareWhatIsEqual)
{
    const toys::Folder folder;
    const auto a = folder.write("a.json", three_frames);
    const auto b = folder.write("b.json", three_frames);
    const auto out = (folder.path / "out").string();
    toys::take_runs("Sum");
    EXPECT_EQ(run({"cook", a, b, "--out", out}).exit, exit_ok);
    EXPECT_EQ(toys::take_runs("Sum"), 3);
    EXPECT_TRUE(std::filesystem::exists(folder.path / "out/a/1number.txt"));
    EXPECT_TRUE(std::filesystem::exists(folder.path / "out/b/1number.txt"));
}

TEST(CommandLine, TheCacheOutlivesTheProcessAndCanBeManaged)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const std::vector<std::string> cook{"cook",    file,
                                        "--out",   (folder.path / "out").string(),
                                        "--cache", (folder.path / "cache").string()};
    toys::take_runs("WriteNumber");
    EXPECT_EQ(run(cook).exit, exit_ok);
    const Said again = run(cook);
    EXPECT_EQ(again.exit, exit_ok);
    // What three sinks wrote, and any value that took long enough to make: whatever stalls a thread
    // for 2 ms decides that.
    std::smatch found;
    ASSERT_TRUE(std::regex_search(again.err, found, std::regex("([0-9]+) from the cache")));
    EXPECT_GE(std::stoi(found[1]), 3) << again.err;
    EXPECT_EQ(toys::take_runs("WriteNumber"), 3) << "the files are as they were written";
    std::filesystem::remove(folder.path / "out/2number.txt");
    EXPECT_EQ(run(cook).exit, exit_ok);
    EXPECT_EQ(toys::take_runs("WriteNumber"), 1);
    const auto cache = [&](const char* what) {
        return run({"cache", what, "--cache", (folder.path / "cache").string()});
    };
    const std::string stat = cache("stat").out;
    ASSERT_TRUE(std::regex_search(stat, found, std::regex("([0-9]+) results, ([0-9]+) values")));
    const int results = std::stoi(found[1]), values = std::stoi(found[2]);
    EXPECT_GE(results, 3) << stat;
    EXPECT_GE(values, 3) << stat;
    const std::string verify = cache("verify").out;
    EXPECT_TRUE(has(verify, fmt::format("{} files good, 0 damaged", results + values))) << verify;
    EXPECT_EQ(cache("gc").exit, exit_ok);
    EXPECT_TRUE(has(cache("clear").out, "0 results"));
    EXPECT_EQ(cache("clean").exit, exit_usage);
}

// As nobody, where the tests run as root: root may read everything.
TEST(CommandLine, ACacheThatMayNotBeReadIsNotSound)
{
    const toys::Folder folder;
    const std::string cache = (folder.path / "cache").string();
    const auto file = folder.write("three.json", three_frames);
    EXPECT_EQ(run({"cook", file, "--out", (folder.path / "out").string(), "--cache", cache}).exit,
              exit_ok);
    std::filesystem::permissions(folder.path, std::filesystem::perms::all);
    std::filesystem::permissions(folder.path / "cache/5/records", std::filesystem::perms::none);
    const int before = ::setfsuid(65534);
    const Said said = run({"cache", "verify", "--cache", cache});
    ::setfsuid(static_cast<uid_t>(before));
    std::filesystem::permissions(folder.path / "cache/5/records",
                                 std::filesystem::perms::owner_all);
    EXPECT_EQ(said.exit, exit_failed) << said.out;
    EXPECT_TRUE(has(said.out, "1 files or folders could not be read")) << said.out;
}

TEST(CommandLine, ANodeIsDescribedByItsNameWithOrWithoutAVersion)
{
    const Said plain = run({"nodes", "Sum"}), numbered = run({"nodes", "Sum@1"});
    EXPECT_EQ(numbered.exit, exit_ok) << numbered.err;
    EXPECT_EQ(numbered.out, plain.out);
}

// A stream that takes nothing, as /dev/full.
TEST(CommandLine, OutputThatCantBeWrittenIsAFailure)
{
    struct Full : std::streambuf {
        int overflow(int) override { return traits_type::eof(); }
    } full;
    const std::vector<std::vector<std::string>> commands{{"schema"}, {"--help"}, {"nodes", "Sum"}};
    for (const std::vector<std::string>& args : commands) {
        std::ostream out(&full);
        std::ostringstream err;
        Console console{out, err, false, {}, {}, "1.2.3"};
        EXPECT_EQ(run_command_line(args, toys::registry(), console), exit_failed) << args[0];
        EXPECT_TRUE(has(err.str(), "standard output can't be written")) << err.str();
    }
}

TEST(CommandLine, ACookRemovesWhatAKilledOneLeft)
{
    const toys::Folder folder;
    const std::string file = folder.write("three.json", three_frames).string();
    const pid_t child = ::fork();
    if (child == 0) ::_exit(0);
    ::waitpid(child, nullptr, 0);
    const std::string gone = std::to_string(child), alive = std::to_string(::getppid());
    const std::vector<std::string> leftovers{
        "video.aspic-" + gone + ".part.mp4", "video.mp4.aspic-" + gone + ".frames",
        "frames/0001.obj.aspic-" + gone + "-3.part", "manifest.json.aspic-" + gone + "-0~"};
    const std::vector<std::string> others{
        "video.aspic-" + alive + ".part.mp4", "video.part.mp4", "a.aspic-" + gone + ".png",
        "notes~",
        // Names that other programs give: of archives, downloads, backups with a date.
        gone + ".part", "archive.7z." + gone + ".part", "below/film." + gone + ".part.mp4",
        "notes-2024." + gone + ".30~", "a." + gone + ".frames", "a." + gone + "-3.part"};
    for (const auto& name : leftovers) folder.write("out/" + name, "half");
    for (const auto& name : others) folder.write("out/" + name, "whole");
    const std::filesystem::path out = folder.path / "out";
    EXPECT_EQ(run({"cook", file, "--out", out.string()}).exit, exit_ok);
    for (const auto& name : leftovers) EXPECT_FALSE(std::filesystem::exists(out / name)) << name;
    for (const auto& name : others) EXPECT_TRUE(std::filesystem::exists(out / name)) << name;
}

TEST(CommandLine, ALinkOutOfTheOutputFolderIsNotWrittenThrough)
{
    const toys::Folder folder;
    folder.write("elsewhere/keep.txt", "mine");
    const std::filesystem::path out = folder.path / "out", outside = folder.path / "elsewhere";
    std::string text = three_frames;
    text.replace(text.find("\"value\": \"sum.value\" }"), 22,
                 R"("value": "sum.value" }, "params": { "path": "frames/n.txt" })");
    const std::string file = folder.write("three.json", text).string();
    const auto cook = [&](const std::filesystem::path& target) {
        std::filesystem::remove_all(out);
        std::filesystem::create_directories(out / "inside");
        std::filesystem::create_symlink(target, out / "frames");
        return run({"cook", file, "--out", out.string()});
    };
    for (const std::filesystem::path& target :
         {outside, std::filesystem::path("../elsewhere"), std::filesystem::path("../nowhere")}) {
        const Said said = cook(target);
        EXPECT_EQ(said.exit, exit_failed) << target;
        EXPECT_TRUE(has(said.err, "leads out of the output folder by a symbolic link")) << said.err;
    }
    EXPECT_EQ(cook("inside").exit, exit_ok) << "a link that stays inside is as good as a folder";
}

TEST(CommandLine, FormattingKeepsLinksAndPermissions)
{
    namespace fs = std::filesystem;
    const toys::Folder folder;
    const fs::path file = folder.write("real/three.json", three_frames);
    const fs::path link = folder.path / "link.json";
    fs::create_symlink("real/three.json", link);
    const fs::perms mine = fs::perms::owner_read | fs::perms::owner_write;
    fs::permissions(file, mine);
    EXPECT_EQ(run({"fmt", link}).exit, exit_ok);
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_NE(runtime::read_text(file), three_frames);
    EXPECT_EQ(fs::status(file).permissions(), mine);
}

TEST(CommandLine, ProfileShowsEachNodeAndWritesATrace)
{
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    const auto trace = folder.path / "trace.json";
    const Said said =
        run({"profile", file, "--out", (folder.path / "out").string(), "--trace", trace.string()});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.out, "write (WriteNumber)")) << said.out;
    EXPECT_TRUE(has(said.out, " of work in ")) << said.out;
    const auto events = nlohmann::json::parse(std::ifstream(trace));
    ASSERT_EQ(events.size(), 9u) << "three nodes at three frames";
    for (const auto& event : events) {
        EXPECT_EQ(event.at("ph"), "X");
        EXPECT_GE(event.at("dur").get<double>(), 0);
        EXPECT_GE(event.at("args").at("frame").get<int>(), 1);
    }
}

TEST(CommandLine, ATimeLimitEndsACookAsCtrlCWould)
{
    const toys::Folder folder;
    const auto file = folder.write("slow.json", R"({ "aspic": 1, "nodes": {
      "one": { "type": "Constant@1" },
      "slow": { "type": "Slow@1", "inputs": { "value": "one.value" },
                "params": { "seconds": 60 } } } })");
    const auto start = std::chrono::steady_clock::now();
    const Said said =
        run({"cook", file, "--out", (folder.path / "out").string(), "--time-limit", "0.05"});
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
    EXPECT_EQ(said.exit, exit_cancelled);
    EXPECT_TRUE(has(said.err, "time limit of 0.05 s was reached")) << said.err;
    EXPECT_EQ(run({"check", file, "--time-limit", "60"}).exit, exit_ok) << "nothing to wait for";
    EXPECT_EQ(run({"cook", file, "--time-limit", "0"}).exit, exit_usage);
}

// 100 %: everything that is found is made again.
TEST(CommandLine, ARecheckFindsADifferenceFromTheStoredResult)
{
    const toys::Folder folder;
    const auto file = folder.write("hidden.json", R"({ "aspic": 1, "nodes": {
      "hidden": { "type": "Hidden@1" },
      "write": { "type": "WriteNumber@1", "inputs": { "value": "hidden.value" } } } })");
    const auto cook = [&](const char* percent) {
        return run({"cook", file, "--out", (folder.path / "out").string(), "--cache",
                    (folder.path / "cache").string(), "--recheck", percent});
    };
    toys::hidden() = 1;
    EXPECT_EQ(cook("0").exit, exit_ok);
    toys::take_runs("WriteNumber");
    EXPECT_EQ(cook("100").exit, exit_ok);
    EXPECT_EQ(toys::take_runs("WriteNumber"), 1);
    toys::hidden() = 2;
    EXPECT_EQ(cook("0").exit, exit_ok) << "nobody looks";
    const Said said = cook("100");
    toys::hidden() = 1;
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(
        has(said.err,
            "differs from the file that was written") ||  // or, where that took 2 ms to make,
        has(said.err, "output 'value' differs from the stored result"))
        << said.err;
    EXPECT_EQ(cook("101").exit, exit_usage);
}

TEST(CommandLine, NewWritesAStarterAndOverwritesNothing)
{
    const toys::Folder folder;
    const auto file = (folder.path / "deep/mine.json").string();
    const Said said = run({"new", file});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.out, "next: aspic cook " + file)) << said.out;
    std::ifstream in(file);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    EXPECT_TRUE(has(text, "aspic cook mine.json")) << "with its own name: " << text;
    EXPECT_EQ(run({"validate", file}).exit, exit_ok);
    EXPECT_EQ(run({"new", file}).exit, exit_usage) << "it is there already";
    EXPECT_TRUE(std::filesystem::exists(folder.path / "deep/mine.json"));
    EXPECT_EQ(run({"new", (folder.path / "short").string()}).exit, exit_ok);
    const Said in_a_file = run({"new", file + "/own.json"});
    EXPECT_EQ(in_a_file.exit, exit_usage);
    EXPECT_TRUE(has(in_a_file.err, "can't be created (Not a directory); choose another"));
    EXPECT_TRUE(std::filesystem::exists(folder.path / "short.json"));
    EXPECT_TRUE(has(run({"new"}).out, "\"aspic\": 1")) << "without a name it is shown";
}

TEST(CommandLine, DoctorNamesTheCacheFolderAndWhatIsMissing)
{
    const toys::Folder folder;
    const Said said = run({"doctor", "--cache", (folder.path / "cache").string()});
    EXPECT_TRUE(has(said.out, "1.2.3")) << said.out;
    EXPECT_TRUE(has(said.out, "ok    cache folder  " + (folder.path / "cache").string()))
        << said.out;
    EXPECT_TRUE(has(said.out, "ffmpeg"));
    const auto blocked = folder.write("file", "no folder");
    EXPECT_TRUE(has(run({"doctor", "--cache", blocked.string()}).out, "can't be written"));
}

TEST(CommandLine, NamesTheMissingArgument)
{
    const auto says = [](const std::vector<std::string>& args, const std::string& words) {
        const Said said = run(args);
        EXPECT_EQ(said.exit, exit_usage);
        EXPECT_TRUE(has(said.err, words)) << said.err;
    };
    says({}, "expected a command:\n  cook");
    says({}, "\n  doctor    Checks");
    says({"cache"}, "cache: expected a subcommand:\n  stat");
    says({"cache", "verfy"}, "there is no command 'verfy'; did you mean 'verify'?");
    says({"cache", "x"}, "there is no command 'x'\n  stat");
    says({"farm", "a.json", "--engin", "slurm"},
         "there is no option '--engin'; did you mean '--engine'?");
    says({"farm", "a.json", "--engine", "slrm"}, "slrm not in {");
    says({"cok", "a.json"}, "did you mean 'cook'?");
    says({"explain", "a.json"}, "explain: expected --frame N (Frame to explain)");
    says({"validate"}, "validate: expected FILE (Graph documents)");
    says({"diff", "a.json"}, "diff: expected 2 x FILE");
    says({"explain", "a.json", "--frame", "x"}, "--frame = x");
    const toys::Folder folder;
    const auto file = folder.write("three.json", three_frames);
    says({"cook", file, "--out", file}, "can't be created (Not a directory); use --out DIR");
    says({"verify", file}, "expected a manifest.json that a cook wrote");
    says({"verify", folder.path}, "manifest.json: can't be read");
}
