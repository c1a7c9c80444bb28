#include "runtime/farm/cut.hpp"

#include "runtime/farm/array_jobs.hpp"
#include "runtime/farm/schedule.hpp"
#include "tests/runtime/toys.hpp"

#include <gtest/gtest.h>

#include <set>

using namespace runtime;

namespace {

using Indices = std::vector<std::uint32_t>;

std::vector<int> frames_to(int last)
{
    std::vector<int> frames;
    for (int f = 1; f <= last; ++f) frames.push_back(f);
    return frames;
}

// A graph made by hand, cut as if each run of a node took what `seconds` says.
struct Cutting {
    toys::Folder folder;
    Caches caches;
    NodeCosts costs;
    double task_seconds = 10;

    Cutting()
    {
        caches.disk = std::make_unique<DiskCache>(folder.path / "cache", 1 << 28, nullptr);
    }
    Options options() const
    {
        Options o;
        o.output_folder = folder.path;
        return o;
    }
    ShotPieces pieces(const graph::Graph& graph, const Indices& targets,
                      const std::vector<int>& frames, const std::string& name = "shot")
    {
        Evaluator evaluator(graph, caches, options());
        std::vector<Want> wants;
        for (const int f : frames) {
            for (const std::uint32_t n : targets) wants.push_back({n, f});
        }
        evaluator.aim(wants);
        costs.seconds.resize(graph.nodes.size(), 0);
        costs.measured = true;
        ShotPieces out{{name, name + ".json", {}, {}, folder.path, 0, 0, true}, frames, {}};
        out.cut = cut_graph({graph, evaluator.keys(), targets, frames, Stored(caches.disk.get()),
                             costs, task_seconds});
        return out;
    }
    Cut cut(const graph::Graph& graph, const Indices& targets, const std::vector<int>& frames)
    {
        std::vector<ShotPieces> shots;
        shots.push_back(pieces(graph, targets, frames));
        return join(shots, task_seconds);
    }
};

std::vector<const FarmTask*> of(const Cut& cut, Stage stage)
{
    std::vector<const FarmTask*> tasks;
    for (const FarmTask& task : cut.tasks) {
        if (task.stage == stage) tasks.push_back(&task);
    }
    return tasks;
}

std::vector<int> all_frames(const std::vector<const FarmTask*>& tasks)
{
    std::vector<int> frames;
    for (const FarmTask* t : tasks) {
        frames.insert(frames.end(), t->frames.begin(), t->frames.end());
    }
    std::sort(frames.begin(), frames.end());
    return frames;
}

using Names = std::vector<std::string>;

}  // namespace

TEST(Cut, ASimulationIsOneTaskAndTheFramesAfterItAreCutByTheirCost)
{
    toys::Wiring w(40);
    const auto clock = w.add("Clock");
    const auto sim = w.add("Accumulate", {{"value", {clock}}});
    const auto slow = w.add("Slow", {{"value", {sim}}});
    const auto sum = w.add("Sum", {{"values", {slow}}});
    Cutting c;
    c.costs.seconds = {0, 0.5, 2, 0};
    const Cut cut = c.cut(w.graph, {sum}, frames_to(40));

    const auto chains = of(cut, Stage::chain), frames = of(cut, Stage::frames);
    ASSERT_EQ(chains.size(), 1u);
    EXPECT_EQ(chains[0]->nodes, Names{w.graph.nodes[sim].name});
    EXPECT_EQ(chains[0]->frames, frames_to(40));
    EXPECT_DOUBLE_EQ(chains[0]->seconds, 40 * 0.5);
    // 80 s of work in tasks of 10 s.
    ASSERT_EQ(frames.size(), 8u);
    EXPECT_EQ(all_frames(frames), frames_to(40)) << "each frame once";
    for (const FarmTask* t : frames) {
        EXPECT_DOUBLE_EQ(t->seconds, 10);
        EXPECT_EQ(t->after, Indices{0});
        EXPECT_EQ(t->nodes, Names{w.graph.nodes[sum].name});
    }
    ASSERT_EQ(cut.tasks.back().stage, Stage::last);
    EXPECT_EQ(cut.tasks.back().after, (Indices{1, 2, 3, 4, 5, 6, 7, 8}))
        << "not after the chain: the others are";
    EXPECT_TRUE(cut.tasks.back().nodes.empty());
}

TEST(Cut, SimulationsThatNeedEachOtherAreOneChainAndOthersAreTheirOwn)
{
    toys::Wiring w(20);
    const auto clock = w.add("Clock");
    const auto first = w.add("Accumulate", {{"value", {clock}}});
    const auto between = w.add("Sum", {{"values", {first}}});
    const auto second = w.add("Accumulate", {{"value", {between}}});
    const auto apart = w.add("Accumulate", {{"value", {clock}}}, {{"start", {3.0}}});
    const auto a = w.add("Slow", {{"value", {second}}});
    const auto b = w.add("Slow", {{"value", {apart}}});
    Cutting c;
    c.costs.seconds = {0, 1, 0, 1, 1, 1, 1};
    const Cut cut = c.cut(w.graph, {a, b}, frames_to(20));
    const auto chains = of(cut, Stage::chain);
    ASSERT_EQ(chains.size(), 2u);
    const auto& names = w.graph.nodes;
    const bool swapped = chains[0]->nodes.size() == 1;
    EXPECT_EQ(chains[swapped]->nodes, (Names{names[first].name, names[second].name}));
    EXPECT_EQ(chains[!swapped]->nodes, Names{names[apart].name});
    EXPECT_TRUE(chains[0]->after.empty());
    EXPECT_TRUE(chains[1]->after.empty()) << "they run at the same time";
}

TEST(Cut, SimulationsThatShareWhatStandsStillAreTheirOwnChains)
{
    toys::Wiring w(20);
    const auto clock = w.add("Clock");
    const auto one = w.add("Constant", {}, {{"value", {1.0}}});
    const auto floor = w.add("Moved", {{"value", {one}}});
    const auto force = w.add("Sum", {{"values", {clock, floor}}});
    const auto a = w.add("Accumulate", {{"value", {force}}});
    const auto b = w.add("Accumulate", {{"value", {force}}}, {{"start", {3.0}}});
    Cutting c;
    c.costs.seconds = {0, 0, 0, 0, 1, 1};
    EXPECT_EQ(of(c.cut(w.graph, {a, b}, frames_to(20)), Stage::chain).size(), 2u);

    w.animate(floor, "scale", [](int f, double) { return f; });
    const Cut moving = c.cut(w.graph, {a, b}, frames_to(20));
    const auto chains = of(moving, Stage::chain);
    ASSERT_EQ(chains.size(), 1u);
    EXPECT_EQ(chains[0]->nodes.size(), 3u);
    EXPECT_EQ(chains[0]->name, "shot.chain-" + w.graph.nodes[b].name) << "what the others feed";
}

TEST(Cut, WhatIsInTheCacheIsNotCookedAgain)
{
    toys::Wiring w(30);
    const auto clock = w.add("Clock");
    const auto slow = w.add("Slow", {{"value", {clock}}}, {{"seconds", {0.004}}});
    Cutting c;
    c.costs.seconds = {0, 2};
    {
        Evaluator evaluator(w.graph, c.caches, c.options());
        std::vector<Want> wants;
        for (int f = 11; f <= 20; ++f) wants.push_back({slow, f});
        evaluator.cook(wants);
        c.caches.disk->flush();
    }
    const ShotPieces pieces = c.pieces(w.graph, {slow}, frames_to(30));
    EXPECT_EQ(pieces.cut.results, 30u);
    EXPECT_EQ(pieces.cut.held, 10u);
    std::vector<int> frames;
    for (const Piece& p : pieces.cut.pieces) {
        frames.insert(frames.end(), p.frames.begin(), p.frames.end());
    }
    std::vector<int> expected = frames_to(30);
    std::erase_if(expected, [](int f) { return f >= 11 && f <= 20; });
    EXPECT_EQ(frames, expected);
}

TEST(Cut, WhatGatheringNodesNeedIsCookedOnceAndBeforeThem)
{
    toys::Wiring w(20);
    const auto clock = w.add("Clock");
    const auto slow = w.add("Slow", {{"value", {clock}}});
    const auto write = w.add("WriteNumber", {{"value", {slow}}});
    const auto some = w.add("Collect", {{"values", {slow}}}, {{"step", {std::int64_t{4}}}});
    Cutting c;
    c.costs.seconds = {0, 5, 0, 7};
    const Cut both = c.cut(w.graph, {write, some}, frames_to(20));
    EXPECT_EQ(all_frames(of(both, Stage::frames)), frames_to(20)) << "not twice at 1, 5, 9 ...";
    EXPECT_DOUBLE_EQ(both.tasks.back().seconds, 7) << "the last task gathers";

    const Cut alone = c.cut(w.graph, {some}, frames_to(20));
    EXPECT_EQ(all_frames(of(alone, Stage::frames)), (std::vector<int>{1, 5, 9, 13, 17}));
    for (const FarmTask* t : of(alone, Stage::frames)) {
        EXPECT_EQ(t->nodes, Names{w.graph.nodes[slow].name});
    }
}

TEST(Cut, FramesThatWereNeverMeasuredAreNotTakenForFreeWhereTheSimulationWas)
{
    // Pictures over a simulation that is in the cache already.
    toys::Wiring w(40);
    const auto clock = w.add("Clock");
    const auto sim = w.add("Accumulate", {{"value", {clock}}});
    const auto slow = w.add("Slow", {{"value", {sim}}});
    Cutting c;
    c.costs.seconds = {0, 0.5, 0};
    const Cut cut = c.cut(w.graph, {slow}, frames_to(40));
    EXPECT_EQ(of(cut, Stage::frames).size(), 4u) << "1 s a frame, in tasks of 10 s";
}

TEST(Cut, TasksAreAnEvenNumber)
{
    toys::Wiring w(15);
    const auto clock = w.add("Clock");
    const auto slow = w.add("Slow", {{"value", {clock}}});
    Cutting c;
    c.costs.seconds = {0, 2};
    // 30 s in tasks of 10 s would be three: 20 s on two machines. Of four, two have to do 8 s and 7
    // s or so each: frames are of 2 s.
    const Cut cut = c.cut(w.graph, {slow}, frames_to(15));
    EXPECT_EQ(of(cut, Stage::frames).size(), 4u);
    EXPECT_LE(makespan(cut, 2), 16);
    // 130 s would be thirteen: 70 s on two machines, in place of 65 s.
    toys::Wiring many(130);
    const auto counted = many.add("Clock");
    const auto light = many.add("Slow", {{"value", {counted}}});
    c.costs.seconds = {0, 1};
    const Cut thirteen = c.cut(many.graph, {light}, frames_to(130));
    EXPECT_EQ(of(thirteen, Stage::frames).size(), 14u);
    EXPECT_LE(makespan(thirteen, 2), 66);
}

TEST(Cut, AShotOfLittleWorkIsOneTask)
{
    toys::Wiring w(20);
    const auto clock = w.add("Clock");
    const auto sim = w.add("Accumulate", {{"value", {clock}}});
    const auto slow = w.add("Slow", {{"value", {sim}}});
    Cutting c;
    c.costs.seconds = {0, 0.2, 0.2};
    const Cut cut = c.cut(w.graph, {slow}, frames_to(20));
    ASSERT_EQ(cut.tasks.size(), 1u);
    EXPECT_EQ(cut.tasks[0].stage, Stage::last);
    EXPECT_NEAR(cut.tasks[0].seconds, 8, 1e-9);
}

TEST(Cut, DearInputsOfASimulationAreCutOffWhenTheyDoNotDependOnIt)
{
    toys::Wiring w(20);
    const auto clock = w.add("Clock");
    const auto dear = w.add("Slow", {{"value", {clock}}});
    const auto sum = w.add("Sum", {{"values", {dear}}});
    const auto sim = w.add("Accumulate", {{"value", {sum}}});
    const auto last = w.add("Sum", {{"values", {sim}}});
    Cutting c;
    c.costs.seconds = {0, 5, 0, 1, 0};
    const Cut cut = c.cut(w.graph, {last}, frames_to(20));
    const auto chains = of(cut, Stage::chain);
    ASSERT_EQ(chains.size(), 1u);
    EXPECT_EQ(chains[0]->after.size(), 10u) << "100 s in tasks of 10 s";
    EXPECT_EQ(cut.tasks[chains[0]->after[0]].nodes, Names{w.graph.nodes[sum].name});
}

TEST(Cut, WhatShotsShareIsCookedOnceBeforeThem)
{
    Cutting c;
    std::vector<ShotPieces> shots;
    for (int i = 0; i < 3; ++i) {
        toys::Wiring w(20);
        const auto still = w.add("Constant");
        const auto body = w.add("Slow", {{"value", {still}}});
        const auto clock = w.add("Clock");
        const auto sim = w.add("Accumulate", {{"value", {clock}}}, {{"start", {1.0}}});
        const auto both = w.add("Sum", {{"values", {body, sim}}}, {{"bias", {double(i)}}});
        c.costs.seconds = {0, 9, 0, 1, 2};
        shots.push_back(c.pieces(w.graph, {both}, frames_to(20), "shot" + std::to_string(i)));
    }
    const Cut cut = join(shots, c.task_seconds);
    EXPECT_EQ(of(cut, Stage::shared).size(), 1u);
    EXPECT_EQ(of(cut, Stage::chain).size(), 1u) << "the same simulation in all three";
    EXPECT_EQ(of(cut, Stage::frames).size(), 12u);
    EXPECT_EQ(of(cut, Stage::last).size(), 3u);
    EXPECT_DOUBLE_EQ(of(cut, Stage::shared)[0]->seconds, 9);
    for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
        for (const std::uint32_t before : cut.tasks[t].after) EXPECT_LT(before, t);
    }
}

// A simulation of 1 s a frame and 1 s a frame of what is made from it, of so many frames.
ShotPieces of_length(Cutting& c, int last, const std::string& name)
{
    toys::Wiring w(last);
    const auto clock = w.add("Clock");
    const auto sim = w.add("Accumulate", {{"value", {clock}}});
    const auto slow = w.add("Slow", {{"value", {sim}}});
    c.costs.seconds = {0, 1, 1};
    return c.pieces(w.graph, {slow}, frames_to(last), name);
}

TEST(Cut, ALongerShotGoesOnFromTheLastFrameOfAShorterOne)
{
    // In any order of the shots, the frames 1-20, 21-30 and 31-40 are a task each.
    for (const std::vector<int>& lengths : {std::vector<int>{20, 40, 30}, {40, 30, 20}}) {
        Cutting c;
        std::vector<ShotPieces> shots;
        for (const int last : lengths) shots.push_back(of_length(c, last, std::to_string(last)));
        const Cut cut = join(shots, c.task_seconds);
        auto chains = of(cut, Stage::chain);
        EXPECT_EQ(all_frames(chains), frames_to(40)) << "each frame once";
        ASSERT_EQ(chains.size(), 3u);
        std::sort(chains.begin(), chains.end(), [](const FarmTask* a, const FarmTask* b) {
            return a->frames.front() < b->frames.front();
        });
        EXPECT_TRUE(chains[0]->after.empty());
        std::set<std::string> names;
        for (std::size_t i = 0; i < 3; ++i) {
            const int first[] = {1, 21, 31};
            EXPECT_EQ(chains[i]->frames.front(), first[i]);
            EXPECT_DOUBLE_EQ(chains[i]->seconds, i == 0 ? 20 : 10);
            names.insert(chains[i]->name);
            if (i == 0) continue;
            ASSERT_EQ(chains[i]->after.size(), 1u);
            EXPECT_EQ(&cut.tasks[chains[i]->after[0]], chains[i - 1]);
        }
        EXPECT_EQ(names.size(), 3u);
        // What is made from them waits for no later ones.
        for (const FarmTask* t : of(cut, Stage::frames)) {
            ASSERT_EQ(t->after.size(), 1u);
            const auto& waited_for = cut.tasks[t->after[0]].frames;
            EXPECT_LE(t->frames.back(), waited_for.back());
            EXPECT_GT(t->frames.back(), waited_for.front());
        }
    }
}

TEST(Cut, AFewMoreFramesAreNoTaskThatOthersWaitFor)
{
    Cutting c;
    const Cut cut = join({of_length(c, 42, "long"), of_length(c, 40, "short")}, c.task_seconds);
    const auto chains = of(cut, Stage::chain);
    ASSERT_EQ(chains.size(), 1u) << "2 s of 42 are not cut off";
    EXPECT_EQ(chains[0]->frames, frames_to(42));
}

TEST(Cut, WhatIsQuicklyMadeIsNotWaitedForUntilALongSimulationEnds)
{
    Cutting c;
    // 3 s of the simulation are the same: less than a task is worth.
    std::vector<ShotPieces> shots;
    shots.push_back(of_length(c, 60, "long"));
    shots.push_back(of_length(c, 3, "short"));
    shots.push_back(of_length(c, 60, "other"));
    for (std::size_t i = 3; i < 60; ++i) {
        shots[2].cut.pieces[0].steps[i].made = {i, 7};  // it goes its own way after that
    }
    const Cut cut = join(shots, c.task_seconds);
    const auto chains = of(cut, Stage::chain);
    ASSERT_EQ(chains.size(), 2u) << "none for the short shot, which is one task";
    EXPECT_EQ(chains[1]->frames, frames_to(60)) << "the first three too";
    EXPECT_TRUE(chains[1]->after.empty());
}

TEST(Cut, ShotsOfLittleWorkThatShareASimulationDoNotSimulateEachForItself)
{
    Cutting c;
    std::vector<ShotPieces> shots;
    for (int i = 0; i < 3; ++i) {
        toys::Wiring w(20);
        const auto clock = w.add("Clock");
        const auto sim = w.add("Accumulate", {{"value", {clock}}});
        const auto sum = w.add("Sum", {{"values", {sim}}}, {{"bias", {double(i)}}});
        c.costs.seconds = {0, 0.3, 0.1};
        shots.push_back(c.pieces(w.graph, {sum}, frames_to(20), "shot" + std::to_string(i)));
    }
    const Cut cut = join(shots, c.task_seconds);
    ASSERT_EQ(cut.tasks.size(), 4u) << "the simulation, 6 s, and a task of 2 s a shot";
    EXPECT_EQ(cut.tasks[0].stage, Stage::chain);
    EXPECT_NEAR(cut.tasks[0].seconds, 6, 1e-9);
    for (std::size_t t = 1; t < 4; ++t) {
        EXPECT_EQ(cut.tasks[t].stage, Stage::last);
        EXPECT_EQ(cut.tasks[t].after, Indices{0});
        EXPECT_NEAR(cut.tasks[t].seconds, 2, 1e-9);
    }
}

TEST(Cut, WhatFeedsTheSimulationsOfSeveralShotsIsCookedOnce)
{
    Cutting c;
    std::vector<ShotPieces> shots;
    for (int i = 0; i < 2; ++i) {
        toys::Wiring w(20);
        const auto clock = w.add("Clock");
        const auto dear = w.add("Slow", {{"value", {clock}}});
        const auto sim = w.add("Accumulate", {{"value", {dear}}}, {{"start", {double(i)}}});
        c.costs.seconds = {0, 5, 1};
        shots.push_back(c.pieces(w.graph, {sim}, frames_to(20), "shot" + std::to_string(i)));
    }
    const Cut cut = join(shots, c.task_seconds);
    EXPECT_EQ(all_frames(of(cut, Stage::frames)), frames_to(20)) << "each frame once";
    const auto chains = of(cut, Stage::chain);
    ASSERT_EQ(chains.size(), 2u);
    EXPECT_EQ(chains[0]->after, chains[1]->after);
}

TEST(Cut, TasksThatAnotherShotMakesLeaveNoGapInTheNamesOfAnArray)
{
    // Of the second shot's five pieces of 10 s, the first shot makes the third.
    const auto shot = [](const std::string& name) {
        ShotPieces pieces{{name, name + ".json", {}, {}, name, 0, 0, true}, frames_to(5), {}};
        for (int f = 1; f <= 5; ++f) {
            Piece piece;
            piece.nodes = {"feed"};
            piece.frames = {f};
            piece.seconds = 10;
            KeyBuilder same;
            same.add(f).add(f == 3 ? std::string("both") : name);
            piece.same = same.key();
            pieces.cut.pieces.push_back(std::move(piece));
        }
        return pieces;
    };
    const Cut cut = join({shot("a"), shot("b")}, 10);
    ASSERT_EQ(of(cut, Stage::frames).size(), 9u);
    std::size_t arrays = 0;
    for (const ArrayJob& array : array_jobs(cut, 1000)) {
        if (array.tasks.size() < 2) continue;
        ++arrays;
        // As the script of an array counts them.
        const std::string& first = cut.tasks[array.tasks.front()].name;
        const std::string stem = first.substr(0, first.rfind('-') + 1);
        for (std::size_t i = 0; i < array.tasks.size(); ++i) {
            const int number = std::stoi(first.substr(stem.size())) + static_cast<int>(i);
            EXPECT_EQ(cut.tasks[array.tasks[i]].name, stem + std::to_string(number));
        }
    }
    EXPECT_EQ(arrays, 2u);
}

TEST(Cut, NothingIsCutFromNothing)
{
    toys::Wiring w(5);
    const auto still = w.add("Constant");
    Cutting c;
    const Cut cut = c.cut(w.graph, {still}, frames_to(5));
    ASSERT_EQ(cut.tasks.size(), 1u) << "a graph without movement is one task";
    EXPECT_TRUE(join({}, 1).tasks.empty());
}

TEST(ArrayJobs, AlikeTasksAreOneArrayAndLongArraysAreSeveral)
{
    Cut cut;
    cut.shots.resize(1);
    FarmTask chain;
    chain.name = "a.chain-sim";
    chain.stage = Stage::chain;
    cut.tasks.push_back(chain);
    for (int i = 1; i <= 7; ++i) {
        FarmTask t;
        t.name = "a.frames-" + std::to_string(i);
        t.stage = Stage::frames;
        t.nodes = {i < 6 ? "one" : "other"};
        t.after = {0};
        cut.tasks.push_back(t);
    }
    FarmTask last;
    last.name = "a.last";
    last.after = {1, 2, 3, 4, 5, 6, 7};
    cut.tasks.push_back(last);
    const std::vector<ArrayJob> jobs = array_jobs(cut, 3);
    std::vector<std::string> names;
    for (const ArrayJob& job : jobs) names.push_back(job.name);
    EXPECT_EQ(names, (Names{"a.chain-sim", "a.frames-1-to-3", "a.frames-4-to-5", "a.frames-6-to-7",
                            "a.last"}));
    EXPECT_EQ(jobs[2].tasks, (Indices{4, 5}));
    EXPECT_EQ(jobs[2].after, Indices{0});
    EXPECT_EQ(jobs[4].after, (Indices{1, 2, 3}));
}
