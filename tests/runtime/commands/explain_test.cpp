#include "runtime/commands/explain.hpp"

#include "runtime/commands/manifest.hpp"
#include "tests/runtime/said.hpp"

#include <gtest/gtest.h>

using namespace runtime;
using toys::has;
using toys::run;
using toys::Said;

namespace {

// A number read from a file, scaled slowly, summed over the frames and written.
class Explained : public testing::Test {
protected:
    std::string document(const std::string& extra = "")
    {
        return R"({ "aspic": 1, "frames": { "first": 1, "last": 4 }, "nodes": {
          "two": { "type": "Constant@1", "params": { "value": 2 } },
          "read": { "type": "ReadNumber@1", "params": { "path": "number.txt" } },
          "slow": { "type": "Slow@1", "inputs": { "value": "read.value" },
                    "params": { "seconds": 0.004 } },
          "sim": { "type": "Accumulate@1", "inputs": { "value": "slow.first" } },
          "write": { "type": "WriteNumber@1", "inputs": { "value": "sim.value" } })" +
               extra + " } }";
    }
    void SetUp() override
    {
        toys::take_runs("Slow");
        number_ = folder_.write("number.txt", "5");
        file_ = folder_.write("graph.json", document()).string();
    }
    Said with(const char* command, std::vector<std::string> more)
    {
        std::vector<std::string> args{command,   file_,
                                      "--out",   (folder_.path / "out").string(),
                                      "--cache", (folder_.path / "cache").string()};
        args.insert(args.end(), more.begin(), more.end());
        return run(args);
    }
    Said cook(std::vector<std::string> more = {}) { return with("cook", std::move(more)); }
    Said explain(std::vector<std::string> more)
    {
        const Said said = with("explain", std::move(more));
        EXPECT_EQ(said.exit, exit_ok) << said.err;
        return said;
    }
    // What is said of one node: "cook input from 'slow' changed"; empty for nothing.
    static std::string of(const std::string& node, const Said& said)
    {
        std::istringstream lines(said.out);
        for (std::string line; std::getline(lines, line);) {
            const std::size_t at = line.find(" " + node + " (");
            if (at == std::string::npos) continue;
            const std::size_t rest = line.find_first_not_of(' ', line.find(')', at) + 1);
            return line.substr(2, 4) + " " + line.substr(rest);
        }
        return {};
    }

    toys::Folder folder_;
    std::filesystem::path number_;
    std::string file_;
};

}  // namespace

TEST_F(Explained, BeforeTheFirstCookEverythingWouldCook)
{
    const Said said = explain({"--frame", "2"});
    EXPECT_TRUE(has(said.out, "at frame 2: 4 nodes would cook, 0 from the cache, 1 not"))
        << said.out;
    EXPECT_EQ(of("write", said), "cook no earlier cook is known");
    EXPECT_TRUE(has(of("sim", said), "frames 1-2: ")) << "a simulation needs its past";
    EXPECT_TRUE(has(said.out, "no ")) << said.out;
    EXPECT_EQ(toys::take_runs("Slow"), 0) << "to explain is not to cook";
}

TEST_F(Explained, AfterACookNothingWould)
{
    ASSERT_EQ(cook().exit, exit_ok);
    const Said said = explain({"--frame", "2"});
    EXPECT_TRUE(has(said.out, "0 nodes would cook, 1 from the cache, 4 not")) << said.out;
    EXPECT_EQ(of("write", said), "keep stored, frame 2");
}

TEST_F(Explained, AChangedParameterIsNamedWithBothValues)
{
    ASSERT_EQ(cook().exit, exit_ok);
    const Said said = explain({"--frame", "3", "--set", "sim.start=10"});
    EXPECT_TRUE(has(of("sim", said), "parameter 'start' is 10, was 0")) << said.out;
    EXPECT_EQ(of("write", said), "cook input from 'sim' changed");
    EXPECT_TRUE(has(of("slow", said), "keep")) << said.out;
}

TEST_F(Explained, ChangedFramesAreNamedWhereANodeDependsOnThem)
{
    const auto with_frames = [&](const char* frames) {
        file_ = folder_.write("graph.json", std::string(R"({ "aspic": 1, "frames": )") + frames +
                                                R"(, "nodes": {
              "clock": { "type": "Clock@1" },
              "moves": { "type": "Constant@1", "params": { "value": "=time" } },
              "still": { "type": "Constant@1" },
              "sum": { "type": "Sum@1", "inputs": {
                       "values": ["clock.value", "moves.value", "still.value"] } },
              "sim": { "type": "Accumulate@1", "inputs": { "value": "sum.value" } },
              "write": { "type": "WriteNumber@1", "inputs": { "value": "sim.value" } } } })");
    };
    with_frames(R"({ "first": 1, "last": 4 })");
    ASSERT_EQ(cook().exit, exit_ok);
    with_frames(R"({ "first": 1, "last": 9, "fps": 25 })");
    const Said fps = explain({"--frame", "3"});
    EXPECT_TRUE(of("clock", fps).ends_with(": fps is 25, was 24")) << fps.out;
    EXPECT_TRUE(of("moves", fps).ends_with(": fps is 25, was 24")) << fps.out;
    EXPECT_TRUE(of("sum", fps).ends_with(": input from 'clock' and 'moves' changed")) << fps.out;
    EXPECT_EQ(of("still", fps).find("fps"), std::string::npos) << fps.out;
    with_frames(R"({ "first": 0, "last": 4 })");
    const Said first = explain({"--frame", "1"});
    EXPECT_TRUE(has(of("clock", first), "the first frame is 0, was 1")) << first.out;
    EXPECT_TRUE(has(of("sim", first), "the first frame is 0, was 1; input from 'sum' changed"))
        << first.out;

    // A manifest of before tells nothing of them.
    const auto path = folder_.path / "out" / manifest_name;
    Manifest old = read_manifest(path);
    ASSERT_TRUE(old.range);
    old.range.reset();
    folder_.write("out/manifest.json", to_text(old));
    EXPECT_EQ(explain({"--frame", "1"}).out.find("was 1"), std::string::npos);
}

TEST_F(Explained, AChangedFileIsNamed)
{
    ASSERT_EQ(cook().exit, exit_ok);
    folder_.write("number.txt", "6");
    const Said said = explain({"--frame", "1"});
    EXPECT_EQ(of("read", said), "cook the contents of " + number_.string() + " changed");
    EXPECT_EQ(of("slow", said), "cook input from 'read' changed");
    EXPECT_EQ(of("two", said), "");
}

TEST_F(Explained, AChangedSideFileIsNamed)
{
    folder_.write("number.txt", "5 more.txt");
    const auto more = folder_.write("more.txt", "1");
    ASSERT_EQ(cook().exit, exit_ok);
    EXPECT_TRUE(has(of("write", explain({"--frame", "1"})), "keep"));
    folder_.write("more.txt", "2");
    const Said said = explain({"--frame", "1"});
    EXPECT_TRUE(has(of("read", said), "contents of " + more.string() + " changed")) << said.out;
}

TEST_F(Explained, AChangedLinkIsNamedWithBothEnds)
{
    ASSERT_EQ(cook().exit, exit_ok);
    std::string text = document();
    const std::string old = "read.value";
    text.replace(text.find(old), old.size(), "two.value");
    folder_.write("graph.json", text);
    const Said said = explain({"--frame", "1"});
    EXPECT_EQ(of("slow", said), "cook input 'value' is two.value, was read.value");
}

TEST_F(Explained, ANewNodeAndANewTypeAreToldApart)
{
    ASSERT_EQ(cook().exit, exit_ok);
    folder_.write("graph.json", document(R"(, "also": { "type": "WriteNumber@1",
        "inputs": { "value": "two.value" }, "params": { "path": "also.txt" } })"));
    const Said said = explain({"--frame", "1"});
    EXPECT_EQ(of("also", said), "cook not part of the last cook");
    EXPECT_EQ(of("write", said), "keep stored, frame 1");
}

TEST_F(Explained, AMissingOutputIsCookedAgain)
{
    ASSERT_EQ(cook().exit, exit_ok);
    std::filesystem::remove(folder_.path / "out/2number.txt");
    EXPECT_EQ(of("write", explain({"--frame", "2"})),
              "cook an output file is missing or was changed");
    EXPECT_TRUE(has(of("write", explain({"--frame", "1"})), "keep"));
}

TEST_F(Explained, AFrameThatTheLastCookLeftOutIsReported)
{
    ASSERT_EQ(cook({"--frames", "1-2"}).exit, exit_ok);
    EXPECT_EQ(of("write", explain({"--frame", "4"})), "cook the last cook covered frames 1-2");
}

TEST_F(Explained, AnEmptiedCacheIsReported)
{
    ASSERT_EQ(cook().exit, exit_ok);
    std::filesystem::remove_all(folder_.path / "cache");
    EXPECT_EQ(of("write", explain({"--frame", "2"})),
              "cook unchanged, but its result is not in the cache");
}

// What it says is what a cook does: the nodes it names run, and no others.
TEST_F(Explained, ItPredictsWhatACookRuns)
{
    ASSERT_EQ(cook().exit, exit_ok);
    for (const char* set : {"sim.start=1", "slow.seconds=0.005", "write.path=other.txt"}) {
        const Said said = explain({"--frame", "4", "--set", set});
        toys::take_runs("Slow"), toys::take_runs("WriteNumber");
        ASSERT_EQ(cook({"--set", set}).exit, exit_ok);
        EXPECT_EQ(toys::take_runs("Slow") > 0, has(of("slow", said), "cook")) << set << said.out;
        EXPECT_EQ(toys::take_runs("WriteNumber") > 0, has(of("write", said), "cook")) << set;
    }
}

TEST_F(Explained, AFrameOutsideTheRangeIsRefused)
{
    const Said said = with("explain", {"--frame", "9"});
    EXPECT_EQ(said.exit, exit_usage);
    EXPECT_TRUE(has(said.err, "frames 1 to 4; frame 9 is outside")) << said.err;
    EXPECT_EQ(with("explain", {}).exit, exit_usage) << "which frame?";
}

TEST_F(Explained, FramesOutsideTheRangeAreToldTogether)
{
    const Said said = with("cook", {"--frames", "3-9"});
    EXPECT_EQ(said.exit, exit_usage);
    EXPECT_TRUE(has(said.err, "frames 1 to 4; 5 of the frames that were asked for, 5 to 9, are"))
        << said.err;
}

// Of what gathers all frames, a contact sheet say, only this one is looked at.
TEST_F(Explained, TheFrameThatIsGatheredIsLookedAt)
{
    file_ = folder_
                .write("graph.json", R"({ "aspic": 1, "frames": { "first": 1, "last": 4 },
        "nodes": {
          "read": { "type": "ReadNumber@1", "params": { "path": "number.txt" } },
          "sim": { "type": "Accumulate@1", "inputs": { "value": "read.value" } },
          "all": { "type": "Collect@1", "inputs": { "values": "sim.value" } } } })")
                .string();
    const Said said = explain({"--frame", "2"});
    EXPECT_TRUE(has(said.out, "'all' gathers many frames; only this one was examined")) << said.out;
    EXPECT_TRUE(has(of("sim", said), "cook frames 1-2: ")) << said.out;
    EXPECT_EQ(of("read", said), "cook no earlier cook is known");
}
