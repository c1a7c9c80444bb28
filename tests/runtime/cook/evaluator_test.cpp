#include "runtime/cook/evaluator.hpp"
#include "runtime/cook/storing.hpp"

#include "tests/runtime/toys.hpp"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <random>
#include <thread>

using namespace runtime;
using toys::number;
using toys::take_runs;
using toys::Wiring;

namespace {

struct Kitchen {
    Caches caches;
    Options options;
    explicit Kitchen(int threads = 2) { options.threads = threads; }

    double pull(const graph::Graph& graph, std::uint32_t node, int frame = 1)
    {
        return number(Evaluator(graph, caches, options).pull({node, 0}, frame));
    }
};

std::vector<Want> at_all_frames(const graph::Graph& graph, std::uint32_t node)
{
    std::vector<Want> wants;
    for (int f = graph.range.first; f <= graph.range.last; ++f) wants.push_back({node, f});
    return wants;
}

// Frame -> value of the node's first output, a number.
std::map<int, double> cook(Evaluator& evaluator, const std::vector<Want>& wants)
{
    std::map<int, double> values;
    evaluator.cook(wants, [&](const Want& w, std::span<const graph::Value> all) {
        values[w.frame] = number(all[0]);
    });
    return values;
}

struct Notes : Observer {
    std::vector<Failure> failures;
    std::vector<Warning> warnings;
    std::vector<std::string> files;
    std::vector<Progress> steps;
    void failed(const Failure& f) override { failures.push_back(f); }
    void warned(const Warning& w) override { warnings.push_back(w); }
    void wrote(std::uint32_t, int, const Written& w) override { files.push_back(w.path); }
    void progressed(const Progress& p) override { steps.push_back(p); }
};

using Events = std::set<std::tuple<std::uint32_t, int, std::string>>;  // node, frame, text

Events warnings_of(const graph::Graph& graph, Kitchen& kitchen, Want want)
{
    Notes notes;
    Evaluator(graph, kitchen.caches, kitchen.options, &notes).cook({want});
    Events told;
    for (const Warning& w : notes.warnings) {
        EXPECT_TRUE(told.insert({w.node, w.frame, w.text}).second) << "told twice: " << w.text;
    }
    return told;
}

}  // namespace

TEST(Evaluator, ADiamondRunsEachNodeOnce)
{
    Wiring w;
    const auto a = w.add("Constant", {}, {{"value", {3.0}}});
    const auto b = w.add("Sum", {{"values", {a}}}, {{"bias", {1.0}}});
    const auto c = w.add("Sum", {{"values", {a}}}, {{"bias", {2.0}}});
    const auto d = w.add("Sum", {{"values", {b, c, c}}});
    take_runs("Constant"), take_runs("Sum");
    EXPECT_EQ(Kitchen().pull(w.graph, d), 4 + 5 + 5);
    EXPECT_EQ(take_runs("Constant"), 1);
    EXPECT_EQ(take_runs("Sum"), 3);
}

TEST(Evaluator, EqualNodesAreOneTask)
{
    Wiring w;
    const auto a = w.add("Constant", {}, {{"value", {3.0}}});
    const auto b = w.add("Constant", {}, {{"value", {3.0}}});
    const auto c = w.add("Sum", {{"values", {a, b}}});
    take_runs("Constant");
    EXPECT_EQ(Kitchen().pull(w.graph, c), 6);
    EXPECT_EQ(take_runs("Constant"), 1);
}

TEST(Evaluator, NothingThatIsNotAskedForRuns)
{
    Wiring w;
    const auto a = w.add("Constant");
    w.add("Sum", {{"values", {a}}});
    take_runs("Sum");
    Kitchen().pull(w.graph, a);
    EXPECT_EQ(take_runs("Sum"), 0);
}

TEST(Evaluator, TheSecondPullRunsNothing)
{
    Wiring w;
    const auto a = w.add("Constant", {}, {{"value", {2.0}}});
    const auto b = w.add("Sum", {{"values", {a, a}}});
    Kitchen kitchen;
    EXPECT_EQ(kitchen.pull(w.graph, b), 4);
    take_runs("Constant"), take_runs("Sum");
    EXPECT_EQ(kitchen.pull(w.graph, b), 4);
    EXPECT_EQ(take_runs("Constant") + take_runs("Sum"), 0);
}

TEST(Evaluator, AnEditRunsWhatDependsOnItAndNoMore)
{
    Wiring w;
    const auto a = w.add("Constant", {}, {{"value", {1.0}}});
    const auto b = w.add("Constant", {}, {{"value", {2.0}}});
    const auto c = w.add("Sum", {{"values", {a}}}, {{"bias", {10.0}}});
    const auto d = w.add("Sum", {{"values", {c, b}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    EXPECT_EQ(number(evaluator.pull({d, 0}, 1)), 13);
    take_runs("Constant"), take_runs("Sum");
    w.graph.nodes[b].params[0] = {5.0};
    evaluator.edited(b);
    EXPECT_EQ(number(evaluator.pull({d, 0}, 1)), 16);
    EXPECT_EQ(take_runs("Constant"), 1);
    EXPECT_EQ(take_runs("Sum"), 1);
    w.graph.nodes[b].params[0] = {2.0};
    evaluator.edited(b);
    EXPECT_EQ(number(evaluator.pull({d, 0}, 1)), 13);
    EXPECT_EQ(take_runs("Constant") + take_runs("Sum"), 0) << "the old results are still there";
}

// 2 + 0 or 1 + 1: the node upstream has another key and gives the same bytes.
TEST(Evaluator, AnEditThatYieldsEqualBytesRecomputesNothing)
{
    Wiring w(3);
    const auto two = w.add("Constant", {}, {{"value", {2.0}}});
    const auto slow = w.add("Slow", {{"value", {two}}}, {{"seconds", {1e-3}}});
    const auto sum = w.add("Sum");
    w.graph.nodes[sum].inputs[0] = {{slow, 1}};
    const auto scale = w.add("Scale", {{"base", {sum}}, {"value", {sum}}});
    const auto all = w.add("Accumulate", {{"value", {scale}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    const double before = number(evaluator.pull({all, 0}, 3));
    for (const char* type : {"Constant", "Slow", "Scale.prepare", "Accumulate"}) take_runs(type);

    w.graph.nodes[two].params[Wiring::param(*w.graph.nodes[two].type, "value")] = {1.0};
    w.graph.nodes[two].params[Wiring::param(*w.graph.nodes[two].type, "whole")] = {std::int64_t{1}};
    evaluator.edited(two);
    EXPECT_EQ(number(evaluator.pull({all, 0}, 3)), before);
    EXPECT_EQ(take_runs("Constant"), 1);
    EXPECT_EQ(take_runs("Slow"), 0);
    EXPECT_EQ(take_runs("Scale.prepare"), 0);

    w.graph.nodes[two].params[Wiring::param(*w.graph.nodes[two].type, "value")] = {3.0};
    evaluator.edited(two);
    EXPECT_NE(number(evaluator.pull({all, 0}, 3)), before);
    EXPECT_EQ(take_runs("Slow"), 1);
    EXPECT_EQ(take_runs("Scale.prepare"), 1);
}

// A constant that changes behind the runtime's back stands for a node that is not pure.
TEST(Evaluator, ARecheckFindsADifferenceFromTheStoredResult)
{
    Wiring w;
    const auto hidden = w.add("Hidden");
    const auto sum = w.add("Sum", {{"values", {hidden}}});
    Kitchen kitchen(1);
    kitchen.options.recheck = 1;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    evaluator.pull({sum, 0}, 1);
    EXPECT_EQ(number(evaluator.pull({sum, 0}, 1)), 1) << "made again and found the same";
    toys::hidden() = 2;
    try {
        evaluator.pull({sum, 0}, 1);
        FAIL();
    } catch (const std::runtime_error& e) {
        EXPECT_NE(std::string(e.what()).find("'value' differs from the stored result"),
                  std::string::npos)
            << e.what();
    }
    toys::hidden() = 1;
}

TEST(Evaluator, ANewLinkIsAnEdit)
{
    Wiring w;
    const auto a = w.add("Constant", {}, {{"value", {1.0}}});
    const auto b = w.add("Clock");
    const auto c = w.add("Sum", {{"values", {a}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    EXPECT_EQ(number(evaluator.pull({c, 0}, 1)), 1);
    w.graph.nodes[c].inputs[0] = {{b, 0}};
    evaluator.edited(c);
    EXPECT_EQ(number(evaluator.pull({c, 0}, 1)), 1);  // frame 1, time 0
    w.graph.nodes[c].inputs[0].push_back({a, 0});
    evaluator.edited(c);
    EXPECT_EQ(number(evaluator.pull({c, 0}, 1)), 2);
}

TEST(Evaluator, AHeldKeyframeAndAStaticBranchCookOnce)
{
    Wiring w(48);
    const auto held = w.add("Constant");
    w.animate(held, "value", [](int frame, double) { return frame < 25 ? 1.0 : frame; });
    const auto still = w.add("Constant", {}, {{"text", {std::string("still")}}});
    const auto sum = w.add("Sum", {{"values", {held, still}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    take_runs("Constant"), take_runs("Sum");
    const auto values = cook(evaluator, at_all_frames(w.graph, sum));
    ASSERT_EQ(values.size(), 48u);
    for (const auto& [f, v] : values) EXPECT_EQ(v, (f < 25 ? 1 : f) + 1 + 5);
    EXPECT_EQ(take_runs("Constant"), 1 + 24 + 1);
    EXPECT_EQ(take_runs("Sum"), 1 + 24);
}

TEST(Evaluator, ASimulationStepsFromItsOwnFrameBefore)
{
    Wiring w(10);
    const auto clock = w.add("Clock");
    const auto sim = w.add("Accumulate", {{"value", {clock}}}, {{"start", {100.0}}});
    // sum over g = 1..f of g + 1000 (g - 1) / 24
    const auto expected = [](int f) {
        double sum = 100;
        for (int g = 1; g <= f; ++g) sum += g + 1000 * ((g - 1) / 24.0);
        return sum;
    };
    for (const int threads : {1, 2, 8}) {
        Kitchen kitchen(threads);
        take_runs("Accumulate");
        EXPECT_EQ(kitchen.pull(w.graph, sim, 7), expected(7));
        EXPECT_EQ(take_runs("Accumulate"), 7);
        EXPECT_EQ(kitchen.pull(w.graph, sim, 3), expected(3));
        EXPECT_EQ(take_runs("Accumulate"), 0) << "scrubbing back is a look-up";
        EXPECT_EQ(kitchen.pull(w.graph, sim, 10), expected(10));
        EXPECT_EQ(take_runs("Accumulate"), 3) << "and forth goes on from the newest state";
    }
}

TEST(Evaluator, WhatRemembersMotionIsOneTaskWhileNothingMoves)
{
    Wiring w(10);
    const auto still = w.add("Constant", {}, {{"value", {3.0}}});
    const auto moved = w.add("Moved", {{"value", {still}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    take_runs("Moved");
    for (const auto& [frame, way] : cook(evaluator, at_all_frames(w.graph, moved))) {
        EXPECT_EQ(way, 0) << frame;
    }
    EXPECT_EQ(take_runs("Moved"), 1);

    w.animate(moved, "scale", [](int f, double) { return f < 4 ? 1.0 : f; });
    evaluator.edited(moved);
    const auto ways = cook(evaluator, at_all_frames(w.graph, moved));
    EXPECT_EQ(ways.at(3), 0);
    EXPECT_EQ(ways.at(4), 9);
    EXPECT_EQ(ways.at(10), 3);
    EXPECT_GE(take_runs("Moved"), 9);  // frames 2 and 3 may be found to have the same inputs

    w.graph.nodes[moved].animated.clear();
    evaluator.edited(moved);
    for (const auto& [frame, way] : cook(evaluator, at_all_frames(w.graph, moved))) {
        EXPECT_EQ(way, 0) << frame;
    }
    EXPECT_EQ(take_runs("Moved"), 0) << "the result from before it moved";
}

TEST(Evaluator, AnEditWhoseEffectStartsAtFrame81KeepsTheFramesBefore)
{
    Wiring w(120);
    const auto force = w.add("Constant");
    w.animate(force, "value", [](int, double) { return 1.0; });
    const auto sim = w.add("Accumulate", {{"value", {force}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    cook(evaluator, at_all_frames(w.graph, sim));
    take_runs("Accumulate");
    w.graph.nodes[force].animated[0].value = [](int f, double) { return f < 81 ? 1.0 : 2.0; };
    evaluator.edited(force);
    const auto values = cook(evaluator, at_all_frames(w.graph, sim));
    EXPECT_EQ(take_runs("Accumulate"), 40);
    EXPECT_EQ(values.at(80), 80);
    EXPECT_EQ(values.at(120), 80 + 2 * 40);
}

TEST(Evaluator, TwoSimulationsFeedEachOtherForward)
{
    Wiring w(30);
    const auto one = w.add("Constant");
    const auto a = w.add("Accumulate", {{"value", {one}}});
    const auto b = w.add("Accumulate", {{"value", {a}}});
    // b(f) = 1 + 2 + ... + f
    EXPECT_EQ(Kitchen().pull(w.graph, b, 30), 465);
}

TEST(Evaluator, AGatheringNodeRunsOnceAndSeesTheFramesItAskedFor)
{
    Wiring w(9);
    const auto clock = w.add("Clock");
    const auto sum = w.add("Sum", {{"values", {clock}}});
    const auto all = w.add("Collect", {{"values", {sum}}}, {{"step", {std::int64_t{4}}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    take_runs("Collect"), take_runs("Clock");
    std::vector<double> numbers;
    const Cooked cooked = evaluator.cook(at_all_frames(w.graph, all),
                                         [&](const Want&, std::span<const graph::Value> values) {
                                             numbers = values[0].as<toys::Numbers>()->all;
                                         });
    EXPECT_EQ(cooked.done, 1u);
    EXPECT_EQ(take_runs("Collect"), 1);
    EXPECT_EQ(take_runs("Clock"), 3);
    EXPECT_EQ(numbers, (std::vector<double>{1e6 + 1, 5e6 + 5 + 1000 * (4 / 24.0),
                                            9e6 + 9 + 1000 * (8 / 24.0)}));
}

TEST(Evaluator, ACookOfFewFramesGathersTheNearestBefore)
{
    Wiring w(9);
    const auto clock = w.add("Clock");
    const auto all = w.add("Collect", {{"values", {clock}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    std::vector<int> frames;
    evaluator.cook({{all, 2}, {all, 4}, {all, 6}},
                   [&](const Want&, std::span<const graph::Value> values) {
                       for (const double x : values[0].as<toys::Numbers>()->all) {
                           frames.push_back(static_cast<int>(x / 1e6));
                       }
                   });
    EXPECT_EQ(frames, (std::vector<int>{2, 2, 4, 4, 6}));
}

TEST(Evaluator, ManyWantsBehindAGatheringNodeDoNotStarveIt)
{
    // Every frame's want waits for the gathering node, which waits for every frame's clock.
    Wiring w(200);
    const auto clock = w.add("Clock");
    const auto all = w.add("Collect", {{"values", {clock}}});
    const auto slow = w.add("Slow", {{"value", {clock}}});
    const auto last = w.add("Sum", {{"values", {clock}}});
    // Count of gathered numbers is not a number on a wire; Sum only has to come after it.
    (void)all, (void)slow;
    graph::Graph& g = w.graph;
    std::vector<Want> wants = at_all_frames(g, last);
    for (const Want& x : at_all_frames(g, all)) wants.push_back(x);
    Kitchen kitchen(1);
    EXPECT_EQ(Evaluator(g, kitchen.caches, kitchen.options).cook(wants).done, 201u);
}

TEST(Evaluator, APreparationLivesAsLongAsWhatItSees)
{
    Wiring w(20);
    const auto base = w.add("Constant", {}, {{"value", {3.0}}});
    const auto clock = w.add("Clock");
    const auto scale = w.add("Scale", {{"base", {base}}, {"value", {clock}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    take_runs("Scale"), take_runs("Scale.prepare");
    const auto values = cook(evaluator, at_all_frames(w.graph, scale));
    EXPECT_EQ(values.at(1), 9);
    EXPECT_EQ(take_runs("Scale"), 20);
    EXPECT_EQ(take_runs("Scale.prepare"), 1);
    w.graph.nodes[scale].params[0] = {3.0};
    evaluator.edited(scale);
    EXPECT_EQ(cook(evaluator, at_all_frames(w.graph, scale)).at(1), 27);
    EXPECT_EQ(take_runs("Scale.prepare"), 1);
}

TEST(Evaluator, AFailureIsNamedOnceAndBlocksWhatDependsOnIt)
{
    Wiring w(5);
    const auto clock = w.add("Constant");
    w.animate(clock, "value", [](int f, double) { return f; });
    const auto bad = w.add("Fail", {{"value", {clock}}}, {{"above", {3.0}}});
    const auto next = w.add("Sum", {{"values", {bad}}});
    const auto last = w.add("Sum", {{"values", {next}}}, {{"bias", {1.0}}});
    const auto other = w.add("Sum", {{"values", {clock}}}, {{"bias", {7.0}}});
    std::vector<Want> wants = at_all_frames(w.graph, last);
    for (const Want& x : at_all_frames(w.graph, other)) wants.push_back(x);
    Kitchen kitchen(1);  // of two threads, the one with frame 5 may be the first to fail
    kitchen.options.keep_going = true;
    Notes notes;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options, &notes);
    const Cooked cooked = evaluator.cook(wants);
    EXPECT_EQ(cooked.done, 3u + 5u);
    EXPECT_EQ(cooked.failures, 2u);
    EXPECT_EQ(cooked.blocked, 4u);
    ASSERT_EQ(notes.failures.size(), 2u);
    EXPECT_EQ(notes.failures[0].node, bad);
    EXPECT_EQ(notes.failures[0].frame, 4);
    EXPECT_EQ(describe(w.graph, notes.failures[0]),
              "'Fail1' (Fail) failed at frame 4: value 4 is too large");
}

TEST(Evaluator, WithoutKeepGoingTheFirstFailureEndsTheCook)
{
    Wiring w(1000);
    const auto clock = w.add("Clock");
    const auto bad = w.add("Fail", {{"value", {clock}}}, {{"above", {0.0}}});
    Kitchen kitchen(1);
    take_runs("Fail");
    const Cooked cooked =
        Evaluator(w.graph, kitchen.caches, kitchen.options).cook(at_all_frames(w.graph, bad));
    EXPECT_EQ(cooked.failures, 1u);
    EXPECT_EQ(take_runs("Fail"), 1);
}

TEST(Evaluator, AnythingThrownIsAnError)
{
    for (const auto& [kind, said] :
         {std::pair<std::string, std::string>{"bad_alloc", "out of memory"},
          {"int", "no std::exception"}}) {
        Wiring w;
        const auto one = w.add("Constant");
        const auto bad = w.add("Fail", {{"value", {one}}}, {{"kind", {kind}}});
        try {
            Kitchen().pull(w.graph, bad);
            FAIL() << kind;
        } catch (const std::runtime_error& e) {
            EXPECT_NE(std::string(e.what()).find(said), std::string::npos) << e.what();
        }
    }
}

TEST(Evaluator, AFailureIsNotKept)
{
    Wiring w;
    const auto one = w.add("Constant");
    const auto bad = w.add("Fail", {{"value", {one}}});
    Kitchen kitchen;
    take_runs("Fail");
    EXPECT_THROW(kitchen.pull(w.graph, bad), std::runtime_error);
    EXPECT_THROW(kitchen.pull(w.graph, bad), std::runtime_error);
    EXPECT_EQ(take_runs("Fail"), 2);
}

TEST(Evaluator, ReadingAVariableThatIsNotDeclaredIsAnError)
{
    Wiring w;
    const auto bad = w.add("Undeclared");
    try {
        Kitchen().pull(w.graph, bad);
        FAIL();
    } catch (const std::runtime_error& e) {
        EXPECT_NE(std::string(e.what()).find("does not declare"), std::string::npos) << e.what();
    }
}

TEST(Evaluator, AnAnimatedValueOutOfItsLimitsFailsThatFrameOnly)
{
    Wiring w(4);
    const auto clock = w.add("Clock");
    const auto slow = w.add("Slow", {{"value", {clock}}});
    w.animate(slow, "size", [](int f, double) { return f == 3 ? -1.0 : 2.0; });
    Kitchen kitchen;
    kitchen.options.keep_going = true;
    Notes notes;
    const Cooked cooked = Evaluator(w.graph, kitchen.caches, kitchen.options, &notes)
                              .cook(at_all_frames(w.graph, slow));
    EXPECT_EQ(cooked.done, 3u);
    ASSERT_EQ(notes.failures.size(), 1u);
    EXPECT_EQ(notes.failures[0].frame, 3);
}

// Where the value is found wrong while a preparation is looked for.
TEST(Evaluator, AFailingAnimatedValueOfAPreparationIsReported)
{
    Wiring w(4);
    const auto clock = w.add("Clock");
    const auto scale = w.add("Scale", {{"base", {clock}}, {"value", {clock}}});
    w.animate(scale, "exponent", [](int f, double) {
        if (f == 3) throw std::invalid_argument("expected a number");
        return 2.0;
    });
    const auto after = w.add("Accumulate", {{"value", {scale}}});
    for (const bool keep_going : {false, true}) {
        Kitchen kitchen;
        kitchen.options.keep_going = keep_going;
        Notes notes;
        const Cooked cooked = Evaluator(w.graph, kitchen.caches, kitchen.options, &notes)
                                  .cook(at_all_frames(w.graph, after));
        EXPECT_LE(cooked.done, 2u);
        EXPECT_EQ(cooked.failures, 1u);
        ASSERT_EQ(notes.failures.size(), 1u);
        EXPECT_EQ(notes.failures[0].node, scale);
        EXPECT_EQ(notes.failures[0].frame, 3);
        EXPECT_EQ(notes.failures[0].what, "expected a number");
    }
}

TEST(Evaluator, AWarningIsShownOnceAndComesBackWithTheStoredResult)
{
    Wiring w(3);
    const auto thin = w.add("Warns");
    const auto clock = w.add("Clock");
    const auto sum = w.add("Sum", {{"values", {thin, clock}}});
    Kitchen kitchen;
    for (int round = 0; round < 2; ++round) {
        Notes notes;
        Evaluator evaluator(w.graph, kitchen.caches, kitchen.options, &notes);
        std::vector<Want> wants = at_all_frames(w.graph, sum);
        wants.push_back({thin, 1});
        evaluator.cook(wants);
        ASSERT_EQ(notes.warnings.size(), 1u) << round;
        EXPECT_EQ(notes.warnings[0].node, thin);
        EXPECT_EQ(notes.warnings[0].text, "a bit thin");
    }
}

TEST(Evaluator, ACachedResultRepeatsTheWarningsOfItsInputs)
{
    Wiring w;
    const auto thin = w.add("Warns");
    const auto flat = w.add("Warns", {}, {{"text", {std::string("flat")}}});
    const auto both = w.add("Sum", {{"values", {flat, thin}}});
    const auto last = w.add("Sum", {{"values", {both}}});
    Kitchen kitchen;
    EXPECT_EQ(warnings_of(w.graph, kitchen, {last, 1}),
              (Events{{thin, 1, "a bit thin"}, {flat, 1, "flat"}}));
    take_runs("Sum");
    EXPECT_EQ(warnings_of(w.graph, kitchen, {last, 1}),
              (Events{{thin, 1, "a bit thin"}, {flat, 1, "flat"}}));
    EXPECT_EQ(take_runs("Sum"), 0);

    // Another graph, in which they stand elsewhere.
    Wiring other;
    other.add("Clock");
    const auto flat_too = other.add("Warns", {}, {{"text", {std::string("flat")}}});
    const auto thin_too = other.add("Warns");
    const auto both_too = other.add("Sum", {{"values", {flat_too, thin_too}}});
    EXPECT_EQ(warnings_of(other.graph, kitchen, {both_too, 1}),
              (Events{{flat_too, 1, "flat"}, {thin_too, 1, "a bit thin"}}));
    EXPECT_EQ(take_runs("Sum"), 0);
}

TEST(Evaluator, TwoNodesWithTheSameWarningAreBothReported)
{
    Wiring w;
    const auto one = w.add("Warns", {}, {{"above", {0.5}}});
    const auto two = w.add("Warns", {}, {{"above", {0.25}}});
    const auto sum = w.add("Sum", {{"values", {one, two}}});
    Kitchen kitchen;
    const Events expected{{one, 1, "a bit thin"}, {two, 1, "a bit thin"}};
    EXPECT_EQ(warnings_of(w.graph, kitchen, {sum, 1}), expected);
    EXPECT_EQ(warnings_of(w.graph, kitchen, {sum, 1}), expected);
}

TEST(Evaluator, ACachedFrameOfASimulationNamesTheFirstFrameThatWarned)
{
    Wiring w(9);
    const auto clock = w.add("Clock");
    const auto thin = w.add("Warns", {{"value", {clock}}}, {{"above", {100.0}}});
    const auto all = w.add("Accumulate", {{"value", {thin}}});
    Kitchen kitchen(1);
    EXPECT_EQ(warnings_of(w.graph, kitchen, {all, 9}), (Events{{thin, 4, "a bit thin"}}));
    EXPECT_EQ(warnings_of(w.graph, kitchen, {all, 9}), (Events{{thin, 4, "a bit thin"}}));
    EXPECT_EQ(warnings_of(w.graph, kitchen, {all, 3}), Events());
    EXPECT_EQ(warnings_of(w.graph, kitchen, {all, 5}), (Events{{thin, 4, "a bit thin"}}));
    const auto both = w.add("Sum", {{"values", {thin, all}}});
    warnings_of(w.graph, kitchen, {both, 9});
    take_runs("Sum");
    EXPECT_EQ(warnings_of(w.graph, kitchen, {both, 9}), (Events{{thin, 4, "a bit thin"}}));
    EXPECT_EQ(take_runs("Sum"), 0);
}

// The value stays the same: what was made from it is taken over, and what was said of it is not.
TEST(Evaluator, AnEditThatYieldsEqualBytesRepeatsNoOldWarnings)
{
    Wiring w;
    const auto thin = w.add("Warns");
    const auto slow = w.add("Slow", {{"value", {thin}}}, {{"seconds", {4e-3}}});
    const toys::Folder folder;
    const auto cook = [&](Kitchen& kitchen) {
        if (!kitchen.caches.disk) {
            kitchen.caches.disk =
                std::make_unique<DiskCache>(folder.path, std::uintmax_t{1} << 30, nullptr);
        }
        Events told = warnings_of(w.graph, kitchen, {slow, 1});
        kitchen.caches.disk->flush();
        return told;
    };
    const auto cook_twice = [&](const std::string& text) {
        w.graph.nodes[thin].params[Wiring::param(*w.graph.nodes[thin].type, "text")] = {text};
        const double quiet = text.empty() ? 2 : 0;
        w.graph.nodes[thin].params[Wiring::param(*w.graph.nodes[thin].type, "above")] = {quiet};
        const Events expected = text.empty() ? Events() : Events{{thin, 1, text}};
        Kitchen kitchen;
        EXPECT_EQ(cook(kitchen), expected) << "taken over from disk";
        EXPECT_EQ(cook(kitchen), expected) << "found in memory";
        Kitchen later;
        EXPECT_EQ(cook(later), expected) << "found on disk";
        return take_runs("Slow");
    };
    take_runs("Slow");
    EXPECT_EQ(cook_twice("a bit thin"), 1);
    EXPECT_EQ(cook_twice("rather thin"), 0);
    EXPECT_EQ(cook_twice(""), 0);
    EXPECT_EQ(cook_twice("thin again"), 0);
    Kitchen kitchen;
    cook(kitchen);
    w.graph.nodes[thin].params[Wiring::param(*w.graph.nodes[thin].type, "text")] = {
        std::string("thinner")};
    EXPECT_EQ(cook(kitchen), (Events{{thin, 1, "thinner"}})) << "taken over from memory";
    EXPECT_EQ(take_runs("Slow"), 0);
}

TEST(Evaluator, StopEndsTheCookAndKeepsWhatIsDone)
{
    Wiring w(100);
    const auto clock = w.add("Clock");
    const auto slow = w.add("Slow", {{"value", {clock}}}, {{"seconds", {1e-3}}});
    for (const int threads : {1, 2}) {
        Kitchen kitchen(threads);
        std::stop_source source;
        kitchen.options.stop = source.get_token();
        Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
        int arrived = 0;
        const Cooked cooked = evaluator.cook(at_all_frames(w.graph, slow),
                                             [&](const Want&, std::span<const graph::Value>) {
                                                 if (++arrived == 10) source.request_stop();
                                             });
        EXPECT_TRUE(cooked.cancelled);
        EXPECT_GE(cooked.done, 10u);
        EXPECT_LT(cooked.done, 10u + 2 * static_cast<unsigned>(threads) + 1);
        EXPECT_EQ(cooked.failures, 0u);
        kitchen.options.stop = {};
        take_runs("Slow");
        Evaluator again(w.graph, kitchen.caches, kitchen.options);
        EXPECT_EQ(again.cook(at_all_frames(w.graph, slow)).done, 100u);
        EXPECT_LE(take_runs("Slow"), 90);
    }
}

TEST(Evaluator, ARunningNodeSeesTheStop)
{
    Wiring w;
    const auto one = w.add("Constant");
    const auto slow = w.add("Slow", {{"value", {one}}}, {{"seconds", {60.0}}});
    Kitchen kitchen;
    std::stop_source source;
    kitchen.options.stop = source.get_token();
    std::jthread stopper([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        source.request_stop();
    });
    const Cooked cooked = Evaluator(w.graph, kitchen.caches, kitchen.options).cook({{slow, 1}});
    EXPECT_TRUE(cooked.cancelled);
    EXPECT_EQ(cooked.failures, 0u);
}

TEST(Evaluator, ATinyMemoryBudgetChangesNoResult)
{
    Wiring w(40);
    const auto clock = w.add("Clock");
    const auto big = w.add("Slow", {{"value", {clock}}}, {{"size", {std::int64_t{1000}}}});
    w.graph.nodes[big].type = toys::registry().find("Slow");
    const auto still = w.add("Constant", {}, {{"value", {5.0}}});
    auto sum = w.add("Sum", {{"values", {clock, still}}});
    w.graph.nodes[sum].inputs[0].push_back({big, 1});
    const auto sim = w.add("Accumulate", {{"value", {sum}}});
    Kitchen rich, poor;
    poor.caches.memory = MemoryCache(10'000);  // one value of 8 kB, or none
    Evaluator a(w.graph, rich.caches, rich.options), b(w.graph, poor.caches, poor.options);
    EXPECT_EQ(cook(a, at_all_frames(w.graph, sim)), cook(b, at_all_frames(w.graph, sim)));
    EXPECT_LE(poor.caches.memory.bytes(), 10'000u);
    EXPECT_EQ(number(b.pull({sim, 0}, 40)), number(a.pull({sim, 0}, 40)));
    Kitchen none;
    none.caches.memory = MemoryCache(0);
    Evaluator c(w.graph, none.caches, none.options);
    EXPECT_EQ(cook(c, at_all_frames(w.graph, sim)), cook(a, at_all_frames(w.graph, sim)));
}

TEST(Evaluator, AChainOfAHundredThousandNodesDoesNotRecurse)
{
    Wiring w;
    auto last = w.add("Constant", {}, {{"value", {0.0}}});
    for (int i = 0; i < 100'000; ++i) last = w.add("Sum", {{"values", {last}}}, {{"bias", {1.0}}});
    EXPECT_EQ(Kitchen().pull(w.graph, last), 100'000);
    // And none of it kept: the whole chain is released from the end.
    Kitchen kitchen;
    kitchen.caches.memory = MemoryCache(0);
    EXPECT_EQ(kitchen.pull(w.graph, last), 100'000);
}

TEST(Evaluator, AHundredThousandFramesOfASimulationDoNotRecurse)
{
    Wiring w(100'000);
    const auto one = w.add("Constant");
    const auto sim = w.add("Accumulate", {{"value", {one}}});
    EXPECT_EQ(Kitchen().pull(w.graph, sim, 100'000), 100'000);
}

TEST(Evaluator, ALateFrameContinuesFromTheLastStoredFrame)
{
    Wiring w(1000);
    const auto clock = w.add("Clock");
    const auto sim = w.add("Accumulate", {{"value", {clock}}});
    Kitchen kitchen;
    const auto expected = [&](int frame) {  // sum of f + 1000 (f - 1) / 24
        return frame * (frame + 1) / 2.0 + 1000 * (frame * (frame - 1) / 2.0) / 24;
    };
    take_runs("Accumulate");
    EXPECT_NEAR(kitchen.pull(w.graph, sim, 400), expected(400), 1e-6);
    EXPECT_EQ(take_runs("Accumulate"), 400);
    EXPECT_NEAR(kitchen.pull(w.graph, sim, 900), expected(900), 1e-6);
    EXPECT_EQ(take_runs("Accumulate"), 500);
    // Several at once, the later ones on top of the earlier, each frame once.
    Kitchen other;
    Evaluator evaluator(w.graph, other.caches, other.options);
    for (const auto& [frame, value] : cook(evaluator, {{sim, 30}, {sim, 1000}, {sim, 7}})) {
        EXPECT_NEAR(value, expected(frame), 1e-6) << frame;
    }
    EXPECT_EQ(take_runs("Accumulate"), 1000);
}

TEST(Evaluator, AFailedEarlierFrameOfASimulationBlocksTheRequestedFrame)
{
    Wiring w(100);
    const auto clock = w.add("Clock");
    const auto checked = w.add("Fail", {{"value", {clock}}}, {{"above", {50'000.0 / 24}}});
    const auto sim = w.add("Accumulate", {{"value", {checked}}});
    for (const bool keep_going : {false, true}) {
        Kitchen kitchen;
        kitchen.options.keep_going = keep_going;
        Notes notes;
        Evaluator evaluator(w.graph, kitchen.caches, kitchen.options, &notes);
        const Cooked cooked = evaluator.cook({{sim, 90}, {sim, 100}});
        EXPECT_EQ(cooked.done, 0u);
        EXPECT_EQ(cooked.failures, 1u);
        ASSERT_EQ(notes.failures.size(), 1u);
        EXPECT_EQ(notes.failures[0].node, checked);
        EXPECT_EQ(notes.failures[0].frame, 50);  // f + 1000 (f - 1) / 24 first exceeds 50000 / 24
    }
}

TEST(Evaluator, AnInputThatIsEmptyIsNamed)
{
    Wiring w;
    graph::NodeType empty = *toys::registry().find("Constant");
    empty.run = [](const graph::Call&) { return std::vector<graph::Value>(1); };
    const auto a = w.add("Constant");
    w.graph.nodes[a].type = &empty;
    const auto bad = w.add("Fail", {{"value", {a}}});
    try {
        Kitchen().pull(w.graph, bad);
        FAIL();
    } catch (const std::runtime_error& e) {
        EXPECT_NE(std::string(e.what()).find("input 'value' is empty: 'Constant0.value'"),
                  std::string::npos)
            << e.what();
    }
}

TEST(Evaluator, AFileCountsByItsBytes)
{
    const toys::Folder folder;
    const auto path = folder.write("a.txt", "5");
    Wiring w;
    const auto read = w.add("ReadNumber", {}, {{"path", {path.string()}}});
    Kitchen kitchen;
    take_runs("ReadNumber");
    EXPECT_EQ(kitchen.pull(w.graph, read), 5);
    EXPECT_EQ(kitchen.pull(w.graph, read), 5);
    EXPECT_EQ(take_runs("ReadNumber"), 1);
    folder.write("a.txt", "6");
    EXPECT_EQ(kitchen.pull(w.graph, read), 6);
    EXPECT_EQ(take_runs("ReadNumber"), 1);
    // Elsewhere, with the same bytes: the same result.
    const auto copy = folder.write("elsewhere/b.txt", "5");
    w.graph.nodes[read].params[0] = {copy.string()};
    EXPECT_EQ(kitchen.pull(w.graph, read), 5);
    EXPECT_EQ(take_runs("ReadNumber"), 0);
}

TEST(Evaluator, AFileThatChangesWhileItIsReadIsNotTrusted)
{
    const toys::Folder folder;
    const auto path = folder.write("a.txt", "5");
    graph::NodeType type = *toys::registry().find("ReadNumber");
    bool meddle = true;
    type.run = [&, run = type.run](const graph::Call& call) {
        auto values = run(call);
        if (std::exchange(meddle, false)) folder.write("a.txt", "7");
        return values;
    };
    Wiring w;
    const auto read = w.add("ReadNumber", {}, {{"path", {path.string()}}});
    w.graph.nodes[read].type = &type;
    Kitchen kitchen;
    kitchen.pull(w.graph, read);
    folder.write("a.txt", "5");
    take_runs("ReadNumber");
    EXPECT_EQ(kitchen.pull(w.graph, read), 5);
    EXPECT_EQ(take_runs("ReadNumber"), 1) << "the torn result was not kept";
}

TEST(Evaluator, ASideFileCountsByItsBytesOrItsAbsence)
{
    const toys::Folder folder;
    const auto path = folder.write("a.txt", "5 b.txt");
    Wiring w;
    const auto read = w.add("ReadNumber", {}, {{"path", {path.string()}}});
    const auto sum = w.add("Sum", {{"values", {read}}});
    Kitchen kitchen;
    take_runs("ReadNumber"), take_runs("Sum");
    EXPECT_EQ(kitchen.pull(w.graph, sum), 5) << "absent";
    EXPECT_EQ(kitchen.pull(w.graph, sum), 5);
    EXPECT_EQ(take_runs("ReadNumber"), 1);
    EXPECT_EQ(take_runs("Sum"), 1);
    folder.write("b.txt", "10");
    EXPECT_EQ(kitchen.pull(w.graph, sum), 15) << "present";
    folder.write("b.txt", "20");
    EXPECT_EQ(kitchen.pull(w.graph, sum), 25) << "changed";
    take_runs("ReadNumber"), take_runs("Sum");
    folder.write("b.txt", "10");
    EXPECT_EQ(kitchen.pull(w.graph, sum), 15) << "as it was";
    EXPECT_EQ(take_runs("ReadNumber"), 0);
    EXPECT_EQ(take_runs("Sum"), 0);
}

TEST(Evaluator, ASideFileThatIsCalledAsTheFileCountsForThatFileAlone)
{
    const toys::Folder folder;
    folder.write("red.more", "10");
    folder.write("green.more", "20");
    Wiring w;
    const auto red =
        w.add("ReadNumber", {}, {{"path", {folder.write("red.txt", "5 *.more").string()}}});
    const auto green =
        w.add("ReadNumber", {}, {{"path", {folder.write("green.txt", "5 *.more").string()}}});
    Kitchen kitchen;
    take_runs("ReadNumber");
    for (int again = 0; again < 2; ++again) {
        EXPECT_EQ(kitchen.pull(w.graph, red), 15);
        EXPECT_EQ(kitchen.pull(w.graph, green), 25);
    }
    EXPECT_EQ(take_runs("ReadNumber"), 2);
    folder.write("green.more", "30");
    EXPECT_EQ(kitchen.pull(w.graph, red), 15);
    EXPECT_EQ(kitchen.pull(w.graph, green), 35);
    EXPECT_EQ(take_runs("ReadNumber"), 1);
}

TEST(Evaluator, ASinkIsSkippedOnlyWhileItsFileIsThere)
{
    const toys::Folder folder;
    Wiring w(3);
    const auto clock = w.add("Clock");
    const auto sink = w.add("WriteNumber", {{"value", {clock}}});
    Kitchen kitchen;
    kitchen.options.output_folder = folder.path;
    const auto wants = at_all_frames(w.graph, sink);
    const auto cook_again = [&] {
        take_runs("WriteNumber");
        Notes notes;
        Evaluator(w.graph, kitchen.caches, kitchen.options, &notes).cook(wants);
        EXPECT_EQ(notes.files.size(), 3u) << "told whether written or kept";
        return take_runs("WriteNumber");
    };
    EXPECT_EQ(cook_again(), 3);
    EXPECT_EQ(cook_again(), 0);
    std::filesystem::remove(folder.path / "2number.txt");
    EXPECT_EQ(cook_again(), 1);
    folder.write("3number.txt", "something else");
    EXPECT_EQ(cook_again(), 1);
    const toys::Folder other;
    kitchen.options.output_folder = other.path;
    EXPECT_EQ(cook_again(), 3);
    EXPECT_TRUE(std::filesystem::exists(other.path / "1number.txt"));
}

TEST(Evaluator, ASinkIsSkippedOnlyWhileWhatLiesBesideItsFileIsThere)
{
    const toys::Folder folder;
    Wiring w(3);
    const auto sink = w.add("WritePair", {{"value", {w.add("Clock")}}});
    Kitchen kitchen;
    kitchen.options.output_folder = folder.path;
    const auto wants = at_all_frames(w.graph, sink);
    const auto cook_again = [&] {
        take_runs("WriteNumber");
        Evaluator(w.graph, kitchen.caches, kitchen.options).cook(wants);
        return take_runs("WriteNumber");
    };
    EXPECT_EQ(cook_again(), 3);
    EXPECT_EQ(cook_again(), 0);
    std::filesystem::remove(folder.path / "2number.txt.note");
    EXPECT_EQ(cook_again(), 1);
    EXPECT_TRUE(std::filesystem::exists(folder.path / "2number.txt.note"));
}

TEST(Evaluator, AnOutputNameMattersToSinksOnly)
{
    Wiring w;
    const auto clock = w.add("Clock");
    const auto sink = w.add("WriteNumber", {{"value", {clock}}});
    Kitchen kitchen;
    Evaluator evaluator(w.graph, kitchen.caches, kitchen.options);
    evaluator.keys().aim({sink}, {1});
    const Key before = evaluator.keys().at(sink, 1), upstream = evaluator.keys().at(clock, 1);
    w.graph.nodes[sink].params[0] = {std::string("other.txt")};
    evaluator.edited(sink);
    evaluator.keys().aim({sink}, {1});
    EXPECT_NE(evaluator.keys().at(sink, 1), before);
    EXPECT_EQ(evaluator.keys().at(clock, 1), upstream);
}

TEST(Evaluator, AFrameBeforeTheFirstIsRefused)
{
    Wiring w;
    const auto a = w.add("Constant");
    EXPECT_THROW(Kitchen().pull(w.graph, a, 0), std::invalid_argument);
}

TEST(Evaluator, NodesOutOfOrderAreRefused)
{
    Wiring w;
    const auto a = w.add("Sum");
    const auto b = w.add("Constant");
    w.graph.nodes[a].inputs[0] = {{b, 0}};
    Kitchen kitchen;
    EXPECT_THROW(Evaluator(w.graph, kitchen.caches, kitchen.options), std::invalid_argument);
}

TEST(Evaluator, ProgressCountsUpToAllAndForetellsTheEnd)
{
    Wiring w(20);
    const auto clock = w.add("Clock");
    const auto slow = w.add("Slow", {{"value", {clock}}}, {{"seconds", {1e-3}}});
    Kitchen kitchen;
    Notes notes;
    Evaluator(w.graph, kitchen.caches, kitchen.options, &notes).cook(at_all_frames(w.graph, slow));
    ASSERT_EQ(notes.steps.size(), 20u);
    for (std::size_t i = 0; i < 20; ++i) EXPECT_EQ(notes.steps[i].done, i + 1);
    EXPECT_GT(notes.steps[9].left, 0);
    EXPECT_EQ(notes.steps[19].left, 0);
}

// A node that runs a parallel loop while other nodes are ready must not get one of them on its
// stack: with one slow node under another's loop, a frame would wait for work that is not its own.
TEST(Evaluator, AParallelLoopInANodeNeverPicksUpAnotherNode)
{
    // Eight bytes: where four are all that is kept for a thread, and their place ends a page, what
    // mold 1.10 links does not start.
    static thread_local std::int64_t depth = 0;
    static std::atomic<std::int64_t> deepest{0};
    deepest = 0;
    graph::NodeType type = *toys::registry().find("Sum");
    type.run = [](const graph::Call&) {
        deepest = std::max(deepest.load(), ++depth);
        tbb::parallel_for(0, 64, [](int) {
            volatile double x = 0;
            for (int i = 0; i < 2000; ++i) x = x + i;
        });
        --depth;
        return std::vector<graph::Value>{graph::Value::of(1.0)};
    };
    Wiring w;
    std::vector<std::uint32_t> all;
    for (int i = 0; i < 200; ++i) {
        all.push_back(w.add("Sum", {}, {{"bias", {static_cast<double>(i)}}}));
        w.graph.nodes.back().type = &type;
    }
    const auto sum = w.add("Sum", {{"values", all}});
    EXPECT_EQ(Kitchen(4).pull(w.graph, sum), 200);
    EXPECT_EQ(deepest, 1);
}

namespace {

// The definition: a value is its node's function of the values of its inputs, computed anew.
double naive(const graph::Graph& g, std::uint32_t n, int frame)
{
    const graph::Node& node = g.nodes[n];
    const std::string& type = node.type->name;
    const auto in = [&](std::size_t port, std::size_t i) {
        return naive(g, node.inputs[port][i].node, frame);
    };
    const double p = std::get<double>(node.params.empty() ? graph::ParamValue{0.0}.is
                                                          : graph::ParamValue(node.params[0]).is);
    if (type == "Clock") return frame + 1000 * g.range.time(frame);
    if (type == "Constant") {
        return node.animated.empty() ? p : node.animated[0].value(frame, g.range.time(frame));
    }
    if (type == "Sum") {
        double sum = p;
        for (std::size_t i = 0; i < node.inputs[0].size(); ++i) sum += in(0, i);
        return sum;
    }
    if (type == "Scale") return std::pow(in(0, 0), p) * in(1, 0);
    if (type == "Fail") return in(0, 0) <= p ? in(0, 0) : throw std::runtime_error("too large");
    if (type == "Moved") {
        const double before = p * naive(g, node.inputs[0][0].node, std::max(frame - 1, 1));
        return p * in(0, 0) - before;
    }
    return (frame > g.range.first ? naive(g, n, frame - 1) : p) + in(0, 0);  // Accumulate
}

graph::Graph random_graph(std::mt19937& random, bool failing = false)
{
    const auto below = [&](std::size_t n) { return static_cast<std::uint32_t>(random() % n); };
    Wiring w(6);
    w.add("Constant", {}, {{"value", {1.0}}});
    for (int i = 0; i < 9; ++i) {
        const auto any = [&] { return below(w.graph.nodes.size()); };
        switch (below(failing ? 8 : 7)) {
        case 0:
            w.add("Constant", {}, {{"value", {static_cast<double>(below(3))}}});
            break;
        case 1: {
            const auto c = w.add("Constant");
            const int hold = static_cast<int>(1 + below(4));
            w.animate(c, "value", [hold](int f, double) {
                const int held = f / hold;
                return static_cast<double>(held);
            });
            break;
        }
        case 2:
            w.add("Clock");
            break;
        case 3:
            w.add("Sum", {{"values", {any(), any(), any()}}});
            break;
        case 4:
            w.add("Scale", {{"base", {any()}}, {"value", {any()}}}, {{"exponent", {1.0}}});
            break;
        case 5:
            w.add("Accumulate", {{"value", {any()}}});
            break;
        case 6:
            w.add("Moved", {{"value", {any()}}}, {{"scale", {static_cast<double>(below(3))}}});
            break;
        default:
            w.add("Fail", {{"value", {any()}}}, {{"above", {static_cast<double>(below(12))}}});
            break;
        }
    }
    return w.graph;
}

}  // namespace

TEST(Evaluator, RandomGraphsGiveWhatTheDefinitionSays)
{
    std::mt19937 random(7);
    for (int round = 0; round < 60; ++round) {
        graph::Graph g = random_graph(random);
        Kitchen kitchen(1 + round % 3);
        if (round % 4 == 0) kitchen.caches.memory = MemoryCache(std::size_t(round) * 100);
        Evaluator evaluator(g, kitchen.caches, kitchen.options);
        for (int edit = 0; edit < 3; ++edit) {
            std::vector<Want> wants;
            for (int i = 0; i < 12; ++i) {
                wants.push_back({static_cast<std::uint32_t>(random() % g.nodes.size()),
                                 static_cast<int>(1 + random() % 6)});
            }
            evaluator.cook(wants, [&](const Want& x, std::span<const graph::Value> values) {
                EXPECT_EQ(number(values[0]), naive(g, x.node, x.frame))
                    << "round " << round << " node " << x.node << " frame " << x.frame;
            });
            const auto n = static_cast<std::uint32_t>(random() % g.nodes.size());
            if (g.nodes[n].params.empty()) continue;
            g.nodes[n].params[0] = {static_cast<double>(random() % 3)};
            evaluator.edited(n);
        }
    }
}

TEST(Evaluator, InRandomGraphsAFailureBlocksWhatDependsOnItAndNothingElse)
{
    std::mt19937 random(3);
    for (int round = 0; round < 120; ++round) {
        const graph::Graph g = random_graph(random, true);
        Kitchen kitchen(1 + round % 3);
        kitchen.options.keep_going = true;
        if (round % 4 == 0) kitchen.caches.memory = MemoryCache(std::size_t(round) * 100);
        Evaluator evaluator(g, kitchen.caches, kitchen.options);
        std::set<Want> wants;
        for (int i = 0; i < 12; ++i) {
            wants.insert({static_cast<std::uint32_t>(random() % g.nodes.size()),
                          static_cast<int>(1 + random() % 6)});
        }
        std::set<Want> good;
        for (const Want& w : wants) {
            try {
                naive(g, w.node, w.frame);
                good.insert(w);
            } catch (const std::runtime_error&) {
            }
        }
        std::set<Want> arrived;
        const Cooked cooked = evaluator.cook({wants.begin(), wants.end()},
                                             [&](const Want& x, std::span<const graph::Value> v) {
                                                 arrived.insert(x);
                                                 EXPECT_EQ(number(v[0]), naive(g, x.node, x.frame));
                                             });
        // A node that is the same at all frames arrives at the first one only.
        std::set<std::uint32_t> still;
        std::erase_if(good, [&](const Want& w) {
            return !evaluator.keys().varies(w.node) && !still.insert(w.node).second;
        });
        EXPECT_EQ(arrived, good) << "round " << round;
        EXPECT_EQ(cooked.done, good.size());
        // Without keep_going nothing worse happens than that less arrives.
        Options options = kitchen.options;
        options.keep_going = false;
        Kitchen another(1 + round % 3);
        const Cooked less =
            Evaluator(g, another.caches, options).cook({wants.begin(), wants.end()});
        EXPECT_LE(less.done, cooked.done);
    }
}

TEST(Evaluator, AnyNumberOfThreadsGivesTheSameBytes)
{
    std::mt19937 random(11);
    for (int round = 0; round < 10; ++round) {
        const graph::Graph g = random_graph(random);
        const auto last = static_cast<std::uint32_t>(g.nodes.size() - 1);
        std::map<int, double> first;
        for (const int threads : {1, 2, 8}) {
            Kitchen kitchen(threads);
            Evaluator evaluator(g, kitchen.caches, kitchen.options);
            const auto values = cook(evaluator, at_all_frames(g, last));
            if (threads == 1) first = values;
            EXPECT_EQ(values, first);
        }
    }
}

// Figures of a result by another key belong to another result, whatever they say.
TEST(ToldFigures, AreTheSameOfTheSameResultsOnly)
{
    const auto told = [](std::uint64_t key, double value) {
        Told out{{key, 1}, 3, "body", "Voxelize", {"body", {{"cubes", value}}}};
        return std::vector<std::shared_ptr<const Told>>{std::make_shared<Told>(std::move(out))};
    };
    const double unknown = graph::Figure::unknown;
    EXPECT_TRUE(tell_the_same(told(1, unknown), told(1, unknown)));
    EXPECT_FALSE(tell_the_same(told(1, 8), told(2, 8)));
    EXPECT_FALSE(tell_the_same(told(1, 8), told(1, 9)));
    EXPECT_FALSE(tell_the_same(told(1, 8), {}));
}
