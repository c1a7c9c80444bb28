// Files that are another one at each frame.

#include "graph/document/document.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/verify.hpp"
#include "runtime/cook/evaluator.hpp"
#include "tests/runtime/said.hpp"

#include <gtest/gtest.h>

using namespace runtime;
using toys::has;
using toys::take_runs;

namespace {

class Sequence : public testing::Test {
protected:
    void SetUp() override
    {
        for (int frame = 1; frame <= 4; ++frame) write(frame, std::to_string(10 * frame));
        file_ = folder_.write("scene.json", R"({ "aspic": 1, "frames": { "first": 1, "last": 4 },
          "nodes": {
            "read": { "type": "ReadNumber@1", "params": { "path": "n.####.txt" } },
            "sum": { "type": "Accumulate@1", "inputs": { "value": "read.value" } },
            "write": { "type": "WriteNumber@1", "inputs": { "value": "sum.value" } } } })");
        graph::Loaded loaded = graph::load_file(file_, toys::registry());
        ASSERT_TRUE(loaded.ok());
        graph_ = std::move(loaded.graph);
        while (graph_.nodes.at(sum_).name != "sum") ++sum_;
        for (const char* type : {"ReadNumber", "Accumulate"}) take_runs(type);
    }
    std::filesystem::path write(int frame, const std::string& text)
    {
        return folder_.write("n.000" + std::to_string(frame) + ".txt", text);
    }
    // The sums at all frames.
    std::vector<double> cook(Evaluator& evaluator)
    {
        std::vector<Want> wants;
        for (int frame = 1; frame <= 4; ++frame) wants.push_back({sum_, frame});
        std::vector<double> values;
        evaluator.cook(wants, [&](const Want&, std::span<const graph::Value> all) {
            values.push_back(toys::number(all[0]));
        });
        return values;
    }

    toys::Folder folder_;
    std::filesystem::path file_;
    graph::Graph graph_;
    std::uint32_t sum_ = 0;
    Caches caches_;
};

using Numbers = std::vector<double>;

}  // namespace

TEST_F(Sequence, EachFrameReadsItsFileOnce)
{
    Evaluator evaluator(graph_, caches_, {});
    EXPECT_EQ(cook(evaluator), (Numbers{10, 30, 60, 100}));
    EXPECT_EQ(take_runs("ReadNumber"), 4);
    EXPECT_EQ(cook(evaluator), (Numbers{10, 30, 60, 100}));
    Evaluator another(graph_, caches_, {});
    EXPECT_EQ(cook(another), (Numbers{10, 30, 60, 100}));
    EXPECT_EQ(take_runs("ReadNumber"), 0);
    EXPECT_EQ(take_runs("Accumulate"), 4);
}

TEST_F(Sequence, AnEditedFileCountsFromItsFrameOn)
{
    Evaluator evaluator(graph_, caches_, {});
    cook(evaluator);
    for (const int third : {31, 33, 30}) {  // the last is as it was
        for (const char* type : {"ReadNumber", "Accumulate"}) take_runs(type);
        write(3, std::to_string(third));
        Evaluator another(graph_, caches_, {});
        const Numbers sums{10, 30, 30.0 + third, 70.0 + third};
        EXPECT_EQ(cook(third == 33 ? another : evaluator), sums);
        EXPECT_EQ(take_runs("ReadNumber"), third == 30 ? 0 : 1);
        EXPECT_EQ(take_runs("Accumulate"), third == 30 ? 0 : 2);
    }
}

TEST_F(Sequence, WhatStandsBesideAFileCountsToo)
{
    write(2, "20 more.txt");
    Evaluator evaluator(graph_, caches_, {});
    EXPECT_EQ(cook(evaluator), (Numbers{10, 30, 60, 100}));
    folder_.write("more.txt", "5");
    EXPECT_EQ(cook(evaluator), (Numbers{10, 35, 65, 105}));
    EXPECT_EQ(cook(evaluator), (Numbers{10, 35, 65, 105}));
    EXPECT_EQ(take_runs("ReadNumber"), 5);
}

TEST_F(Sequence, WhatIsCalledAsAFrameCountsForThatFrameAlone)
{
    write(2, "20 *.more");
    write(3, "20 *.more");
    folder_.write("n.0002.more", "5");
    folder_.write("n.0003.more", "7");
    for (const bool again : {false, true}) {
        Evaluator evaluator(graph_, caches_, {});
        EXPECT_EQ(cook(evaluator), (Numbers{10, 35, 62, 102}));
        EXPECT_EQ(take_runs("ReadNumber"), again ? 0 : 4);
    }
}

TEST_F(Sequence, AFileThatIsNotThereFailsItsFrame)
{
    std::filesystem::remove(folder_.path / "n.0003.txt");
    const toys::Said said = toys::run(
        {"cook", file_.string(), "--out", (folder_.path / "out").string(), "--keep-going"});
    EXPECT_EQ(said.exit, exit_failed);
    EXPECT_TRUE(has(said.err, "failed at frame 3")) << said.err;
    EXPECT_TRUE(has(said.err, "n.0003.txt; the sequence has files from frame 1 to 4")) << said.err;
    EXPECT_TRUE(std::filesystem::exists(folder_.path / "out/2number.txt"));
    // Nothing of that is kept.
    write(3, "30");
    EXPECT_EQ(toys::run({"cook", file_.string(), "--out", (folder_.path / "out").string()}).exit,
              exit_ok);
}

TEST_F(Sequence, AFileThatChangesWhileItIsReadIsNotTrusted)
{
    std::uint32_t read = 0;
    while (graph_.nodes.at(read).name != "read") ++read;
    graph::NodeType type = *graph_.nodes[read].type;
    bool meddle = true;
    type.run = [&, run = type.run](const graph::Call& call) {
        auto values = run(call);
        if (toys::number(values[0]) == 20 && std::exchange(meddle, false)) write(2, "25");
        return values;
    };
    graph_.nodes[read].type = &type;
    Evaluator first(graph_, caches_, {});
    cook(first);
    write(2, "20");
    take_runs("ReadNumber");
    Evaluator second(graph_, caches_, {});
    EXPECT_EQ(cook(second), (Numbers{10, 30, 60, 100}));
    write(2, "25");
    Evaluator third(graph_, caches_, {});
    EXPECT_EQ(cook(third), (Numbers{10, 35, 65, 105}));
    EXPECT_EQ(take_runs("ReadNumber"), 1) << "the torn result was not kept, what came after was";
}

TEST_F(Sequence, VerifyNamesAFileThatChanged)
{
    const std::string out = (folder_.path / "out").string();
    ASSERT_EQ(toys::run({"cook", file_.string(), "--out", out}).exit, exit_ok);
    const auto verify = [&] { return toys::run({"verify", out + "/" + manifest_name}); };
    EXPECT_EQ(verify().exit, exit_ok);
    const std::string changed = write(2, "21").string();
    EXPECT_TRUE(has(verify().out, "changed since the cook: " + changed)) << verify().out;
}
