#include "runtime/commands/tune.hpp"

#include "runtime/commands/command_line.hpp"
#include "tests/runtime/toys.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <sstream>

using namespace runtime;

namespace tuned_models {
namespace {

// A model whose error is known: value = 2 + size^power + 0.1 / substeps. It can't do all sizes.
struct Model {
    struct Step {
        int substeps = 2;
    };
    struct Inputs {
        double size = 0.4;
        double power = 2;
        double coarsest = 100;
        Step step;
    };
    static toys::Number run(const Inputs& in, const graph::Context&)
    {
        ++toys::runs().of["Model"];
        if (in.size > in.coarsest) throw std::invalid_argument("expected smaller cubes");
        return {2 + std::pow(in.size, in.power) + 0.1 / in.step.substeps};
    }
};

void describe_step(graph::ParamsOf<Model::Step>& p)
{
    p.param("substeps", &Model::Step::substeps, "Steps a frame.", {.min = 1, .max = 1000});
}

const graph::Registry& models()
{
    static const graph::Registry all = [] {
        graph::Registry r;
        r.add("Model", 1, Model::run)
            .param("size", &Model::Inputs::size, "Edge of its cubes.")
            .param("power", &Model::Inputs::power, "Order of convergence.")
            .param("coarsest", &Model::Inputs::coarsest, "Largest size that it can do.")
            .block("step", &Model::Inputs::step, describe_step, "Its steps.")
            .output("value", &toys::Number::value, "The result.");
        return r;
    }();
    return all;
}

const char* const document = R"({ "aspic": 1, "frames": { "first": 1, "last": 2 }, "nodes": {
    "model": { "type": "Model@1" } } })";

Tuning tuned(double error, const std::vector<std::pair<std::string, std::string>>& sets = {})
{
    const toys::Folder folder;
    TuneOptions options;
    options.error = error;
    options.size = "model.size";
    for (const auto& [target, value] : sets) options.sweep.load.sets.push_back({target, value});
    Caches caches;
    return tune(folder.write("t.json", document), models(), options, caches);
}

int run(std::vector<std::string> args, std::string& out, std::string& err)
{
    std::ostringstream o, e;
    Console console{o, e, false, {}, {}, "test"};
    args.emplace_back("--no-disk-cache");
    const int exit = run_command_line(args, models(), console);
    out = o.str(), err = e.str();
    return exit;
}

TEST(LimitOf, ValuesThatConvergeGivesTheirLimitAndOrder)
{
    for (const double order : {1.0, 1.5, 2.0}) {
        const auto at = [&](double h) { return 3 + 0.2 * std::pow(h, order); };
        const Limit limit = limit_of({at(1), at(2), at(4)});
        EXPECT_NEAR(limit.value, 3, 1e-12);
        EXPECT_NEAR(limit.order, order, 1e-12);
        EXPECT_NEAR(limit.uncertainty, 0.25 * 0.2, 1e-12);
    }
}

TEST(LimitOf, ValuesThatDoNotConvergeYetIsAsUncertainAsTheirChange)
{
    for (const auto& values : {std::array{1.0, 2.0, 2.5}, std::array{1.0, 2.0, 1.5}}) {
        const Limit limit = limit_of(values);
        EXPECT_EQ(limit.value, 1);
        EXPECT_GE(limit.uncertainty, 1);
        EXPECT_EQ(limit.order, 0);
    }
    // Faster than cubes and steps can: the last change is taken for a quarter of the one before.
    EXPECT_NEAR(limit_of({1, 1.03, 4}).value, 0.99, 1e-12);
    EXPECT_EQ(limit_of({5, 5, 5}).uncertainty, 0);
}

TEST(Tune, TakesTheCoarsestSizeAndTheLongestStepsThatTogetherMeetTheError)
{
    // Of 2: 7 % for the size, which leaves 0.375; size 0.2 is 0.04 off, size 0.4 0.16, size 0.8
    // 0.64. Steps then get what is left of 10 %: 1 substep is 0.1 off, 2 0.05.
    const Tuning tuning = tuned(0.1);
    EXPECT_TRUE(tuning.reached);
    ASSERT_EQ(tuning.recommended.size(), 2u);
    EXPECT_EQ(describe(tuning.recommended), "model.size=0.2 model.step.substeps=1");
    EXPECT_LE(tuning.error, 0.1);
    EXPECT_NEAR(tuning.error, (0.04 + 0.1) / 2, 0.015);
}

TEST(Tune, StaysWithinTheErrorOfWhatItCannotSee)
{
    for (const char* power : {"1", "1.5", "2"}) {
        for (const double error : {0.02, 0.05, 0.1, 0.2}) {
            const Tuning tuning = tuned(error, {{"model.power", power}});
            if (!tuning.reached) continue;
            const double size = std::stod(tuning.recommended[0].value);
            const double substeps = std::stod(tuning.recommended[1].value);
            const double off = std::pow(size, std::stod(power)) + 0.1 / substeps;
            EXPECT_LE(off / 2, error) << power << " " << error;
        }
    }
}

TEST(Tune, TriesCoarserSizesAsLongAsTheyAreGoodEnough)
{
    const Tuning tuning = tuned(0.05, {{"model.size", "0.01"}, {"model.step.substeps", "16"}});
    EXPECT_TRUE(tuning.reached);
    EXPECT_EQ(tuning.recommended[0].value, "0.16");
}

TEST(Tune, ASizeThatFailsIsPassedOver)
{
    const Tuning tuning = tuned(0.1, {{"model.coarsest", "0.5"}});
    EXPECT_TRUE(tuning.reached);
    EXPECT_NE(tuning.tried[0][0].failure, "");
    EXPECT_EQ(tuning.recommended[0].value, "0.2");
}

TEST(Tune, WhatIsNotReachedIsSaid)
{
    const Tuning tuning = tuned(1e-9);
    EXPECT_FALSE(tuning.reached);
    EXPECT_EQ(tuning.tried[0].size(), 6u);
    EXPECT_GT(tuning.error, 1e-9);
}

TEST(Tune, StopsAtAnySettingWhenItIsCancelled)
{
    const toys::Folder folder;
    const auto file = folder.write("t.json", document);
    // Refined to size 0.0125, or made coarser from 0.01 on, before the steps.
    for (const char* const size : {"0.4", "0.01"}) {
        for (int after = 1; after <= 5; ++after) {
            std::stop_source source;
            TuneOptions options;
            options.error = 0.05, options.size = "model.size";
            options.sweep.load.sets.push_back({"model.size", size});
            options.sweep.cook.stop = source.get_token();
            Caches caches;
            int done = 0, begun = 0;
            options.begins = [&](const Settings& settings) {
                EXPECT_EQ(settings[0].target, "model.size");
                EXPECT_EQ(++begun, done + 1);
            };
            const Tuning tuning = tune(file, models(), options, caches, [&](const Tuned&) {
                if (++done == after) source.request_stop();
            });
            EXPECT_TRUE(tuning.cancelled) << size << " " << after;
            EXPECT_EQ(done, after) << size;
            EXPECT_GE(begun, done);
            std::size_t kept = 0;
            for (const auto& tried : tuning.tried) kept += tried.size();
            EXPECT_EQ(kept, static_cast<std::size_t>(after)) << "of what was cooked, " << size;
        }
    }
}

// Up to 1000 steps a frame.
TEST(Tune, StopsAtTheEndOfTheRangeOfAParameter)
{
    const auto tried = [](const char* substeps) {
        const Tuning tuning = tuned(1e-9, {{"model.step.substeps", substeps}});
        EXPECT_FALSE(tuning.reached);
        EXPECT_EQ(tuning.at_end, "model.step.substeps");
        std::vector<std::string> values;
        for (const Tuned& t : tuning.tried.at(1)) {
            values.push_back(t.settings.back().value);
            EXPECT_TRUE(std::isfinite(t.error)) << values.back();
        }
        return values;
    };
    EXPECT_EQ(tried("300"), (std::vector<std::string>{"150", "300", "600"}));
    EXPECT_EQ(tried("800"), (std::vector<std::string>{"200", "400", "800"}));
}

TEST(Tune, ANodeWithoutCubesCanBeTuned)
{
    const toys::Folder folder;
    TuneOptions options;
    options.error = 0.1;
    options.size = "model.size";
    options.count_cubes = [](const graph::Value&) { return 1.0; };
    Caches caches;
    const Tuning tuning = tune(folder.write("t.json", document), models(), options, caches);
    EXPECT_TRUE(tuning.reached);
    for (const Tuned& t : tuning.tried.at(0)) {
        EXPECT_EQ(t.failure, "");
        EXPECT_EQ(t.cubes, 0);
    }
}

TEST(Tune, PrintsATableARecommendationAndLinesOfJson)
{
    const toys::Folder folder;
    const std::string file = folder.write("t.json", document).string();
    std::string out, err;
    const std::vector<std::string> args{"tune", file, "--error", "10%", "--size", "model.size"};
    EXPECT_EQ(run(args, out, err), exit_ok) << err;
    EXPECT_NE(out.find("Coarsest setting within 10 %: model.size=0.2 model.step.substeps=1"),
              std::string::npos)
        << out;
    auto json = args;
    json.emplace_back("--json");
    EXPECT_EQ(run(json, out, err), exit_ok) << err;
    std::istringstream lines(out);
    std::string line, last;
    while (std::getline(lines, line)) {
        last = line;
        EXPECT_TRUE(nlohmann::json::accept(line)) << line;
    }
    EXPECT_EQ(nlohmann::json::parse(last)["recommended"]["model.size"], 0.2);
    EXPECT_EQ(run({"tune", file, "--error", "1e-9", "--size", "model.size"}, out, err),
              exit_missed);
}

// As where the parameters themselves are named: a number that counts is doubled.
TEST(Tune, TakesVariablesForTheSizeAndTheSteps)
{
    const toys::Folder folder;
    const std::string file = folder
                                 .write("t.json", R"({ "aspic": 1, "frames": { "last": 2 },
        "variables": { "cell": 0.4, "steps": 2 }, "nodes": { "model": { "type": "Model@1",
          "params": { "size": "=cell", "step": { "substeps": "=steps" } } } } })")
                                 .string();
    std::string out, err;
    EXPECT_EQ(run({"tune", file, "--error", "10%", "--size", "cell", "--steps", "steps"}, out, err),
              exit_ok)
        << err;
    EXPECT_NE(out.find("Coarsest setting within 10 %: cell=0.2 steps=1 "), std::string::npos)
        << out;
    EXPECT_EQ(run({"tune", file, "--size", "cel"}, out, err), exit_usage);
    EXPECT_NE(err.find("found no such variable 'cel'; did you mean 'cell'?"), std::string::npos)
        << err;
    EXPECT_EQ(run({"tune", file, "--size", "cell", "--steps", "cell"}, out, err), exit_usage);
    EXPECT_NE(err.find("found 'cell' for both: leave one out"), std::string::npos) << err;
    // Beyond the range of the parameter that follows it nothing is tried.
    EXPECT_EQ(run({"tune", file, "--error", "1e-9", "--size", "cell", "--steps", "steps", "--var",
                   "steps=800"},
                  out, err),
              exit_missed);
    EXPECT_NE(out.find("The range of steps ends there."), std::string::npos) << out;
}

// A variable that the size shrinks with, and one that the steps are twice of.
TEST(Tune, TakesVariablesThatMakeFinerWhatFollowsThemAsTheyGrow)
{
    const toys::Folder folder;
    const std::string file = folder
                                 .write("t.json", R"({ "aspic": 1, "frames": { "last": 2 },
        "variables": { "across": 2.5, "half": 1 }, "nodes": { "model": { "type": "Model@1",
          "params": { "size": "=1 / across", "step": { "substeps": "=2 * half" } } } } })")
                                 .string();
    std::string out, err;
    EXPECT_EQ(
        run({"tune", file, "--error", "10%", "--size", "across", "--steps", "half"}, out, err),
        exit_ok)
        << err;
    EXPECT_NE(out.find("Coarsest setting within 10 %: across=5 half=1 "), std::string::npos) << out;
}

// Whole at first, as a count is; but it is the count that must be.
TEST(Tune, HalvesAWholeVariableThatACountShrinksWith)
{
    const toys::Folder folder;
    const std::string file = folder
                                 .write("t.json", R"({ "aspic": 1, "frames": { "last": 2 },
        "variables": { "cell": 0.4, "ms": 2 }, "nodes": { "model": { "type": "Model@1",
          "params": { "size": "=cell", "step": { "substeps": "=4 / ms" } } } } })")
                                 .string();
    std::string out, err;
    EXPECT_EQ(run({"tune", file, "--error", "1%", "--size", "cell", "--steps", "ms"}, out, err),
              exit_ok)
        << err;
    EXPECT_NE(out.find("Coarsest setting within 1 %: cell=0.1 ms=0.25 "), std::string::npos) << out;
}

TEST(Tune, MistakesAreSaid)
{
    const toys::Folder folder;
    const std::string file = folder.write("t.json", document).string();
    std::string out, err;
    EXPECT_EQ(run({"tune", file, "--error", "much"}, out, err), exit_usage);
    EXPECT_NE(err.find("expected 5% or 0.05 for --error, found 'much'"), std::string::npos) << err;
    EXPECT_EQ(run({"tune", file, "--size", "model.sise"}, out, err), exit_usage);
    EXPECT_NE(err.find("found no such parameter 'model.sise'"), std::string::npos) << err;
}

}  // namespace
}  // namespace tuned_models
