#include "runtime/commands/study.hpp"

#include "graph/types/node_builder.hpp"
#include "graph/types/standard_wires.hpp"
#include "graph/types/wire_type.hpp"
#include "runtime/commands/command_line.hpp"
#include "runtime/commands/sweep.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

namespace study_test {

using namespace runtime;

// x' = -x from 1, by `steps` steps of Euler's method a frame: at frame f the exact value is
// exp(-t), the computed one (1 - h)^(n f). Its global error is of first order.
enum class Rule { euler, other };
struct Decay {
    graph::Wire<double> before;
    int steps = 1;
    Rule rule = Rule::euler;
    double weight = 1;  // of the other rule
    bool broken = false;
};
struct DecayOut {
    double value = 1;
};
static DecayOut decay(const Decay& in, const graph::Context& context)
{
    if (in.broken) throw std::runtime_error("it was told to break");
    DecayOut out;
    if (in.steps == 1) context.warn("one step is few");
    if (!in.before) return out;
    out.value = *in.before;
    for (int i = 0; i < in.steps; ++i) out.value -= out.value * context.frame_seconds() / in.steps;
    return out;
}

static const graph::Registry& toys()
{
    static const graph::Registry all = [] {
        graph::Registry r;
        r.add("Decay", 1, decay)
            .summary("Euler's method on x' = -x.")
            .param("steps", &Decay::steps, "Steps a frame.", {.min = 1})
            .choice("rule", &Decay::rule, {"euler", "other"}, "Which rule.")
            .param("weight", &Decay::weight, "Of other.", {}, {"rule", {"other"}})
            .param("broken", &Decay::broken, "Whether to fail.")
            .output("value", &DecayOut::value, "x.")
            .previous("value", &Decay::before)
            .reads(graph::Variable::fps);
        return r;
    }();
    return all;
}

class Study : public testing::Test {
protected:
    void SetUp() override
    {
        folder_ =
            std::filesystem::temp_directory_path() / ("aspic_study_" + std::to_string(::getpid()));
        std::filesystem::create_directories(folder_);
        file_ = folder_ / "decay.json";
        std::ofstream(file_) << R"({ "aspic": 1, "frames": { "first": 0, "last": 10, "fps": 10 },
            "nodes": { "x": { "type": "Decay@1" } } })";
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    StudyOptions options(std::vector<Vary> varied) const
    {
        StudyOptions o;
        o.varied = std::move(varied);
        o.measures = {"x.value"};
        return o;
    }

    std::filesystem::path folder_, file_;
};

TEST_F(Study, TheErrorAgainstAnExactValueIsTheDifferenceAtThatFrame)
{
    StudyOptions o = options({{"x.steps", {"1", "10"}}});
    o.frames = {10};  // t = 1
    o.exact = std::exp(-1.0);
    const std::vector<Trial> trials = study(file_, toys(), o);
    ASSERT_EQ(trials.size(), 2u);
    EXPECT_NEAR(trials[0].error, std::exp(-1.0) - std::pow(0.9, 10), 1e-15);
    EXPECT_NEAR(trials[1].error, std::exp(-1.0) - std::pow(0.99, 100), 1e-14);
    // First order: ten times the steps, a tenth of the error, up to the next order's 5 %.
    EXPECT_NEAR(trials[0].error / trials[1].error, 10, 0.6);
    EXPECT_NEAR(trials[0].relative, trials[0].error / std::exp(-1.0), 1e-15);
}

TEST_F(Study, WithoutAReferenceTheLastCombinationIsIt)
{
    const std::vector<Trial> trials =
        study(file_, toys(), options({{"x.steps", {"1", "2", "64"}}}));
    EXPECT_TRUE(trials[2].reference);
    EXPECT_EQ(trials[2].error, 0);
    // Root mean square over all 11 frames of the difference of two closed forms.
    double sum_sq = 0;
    for (int f = 0; f <= 10; ++f) {
        const double d = std::pow(1 - 0.1, f) - std::pow(1 - 0.1 / 64, 64 * f);
        sum_sq += d * d;
    }
    EXPECT_NEAR(trials[0].error, std::sqrt(sum_sq / 11), 1e-14);
    EXPECT_LT(trials[1].error, trials[0].error);
}

// The first measure decides; of the others the value and the error are told.
TEST_F(Study, SeveralMeasuresAreToldWithTheirValues)
{
    std::ofstream(file_) << R"({ "aspic": 1, "frames": { "first": 0, "last": 10, "fps": 10 },
        "nodes": { "x": { "type": "Decay@1" }, "y": { "type": "Decay@1",
        "params": { "steps": 2 } } } })";
    StudyOptions o = options({{"x.steps", {"1", "64"}}});
    o.measures = {"y.value", "x.value"};
    const std::vector<Trial> trials = study(file_, toys(), o);
    const double y = std::pow(1 - 0.05, 20), coarse = std::pow(0.9, 10),
                 fine = std::pow(1 - 0.1 / 64, 640);
    double sum_sq = 0;
    for (int f = 0; f <= 10; ++f) {
        const double d = std::pow(1 - 0.1, f) - std::pow(1 - 0.1 / 64, 64 * f);
        sum_sq += d * d;
    }
    for (const Trial& t : trials) {
        ASSERT_EQ(t.measured.size(), 2u);
        EXPECT_EQ(t.measured[0].wire, "y.value");
        EXPECT_NEAR(t.measured[0].value, y, 1e-14);
        EXPECT_NEAR(t.measured[1].value, t.reference ? fine : coarse, 1e-14);
    }
    EXPECT_EQ(trials[0].error, 0);
    EXPECT_NEAR(trials[0].measured[1].error, std::sqrt(sum_sq / 11), 1e-14);
    EXPECT_TRUE(std::isnan(trials[1].measured[1].error)) << "the reference itself";
    const std::string csv = to_csv(trials);
    EXPECT_NE(csv.find(",\"y.value\",\"y.value error_rms\",\"x.value\",\"x.value error_rms\"\n"),
              std::string::npos)
        << csv;
    EXPECT_NE(csv.find(fmt::format(",{:.9g},0,{:.9g},{:.9g}\n", y, coarse, std::sqrt(sum_sq / 11))),
              std::string::npos)
        << csv;
    o.exact = 0.5;
    const std::vector<Trial> exact = study(file_, toys(), o);
    EXPECT_NEAR(exact[1].measured[1].value, fine, 1e-14);
    EXPECT_TRUE(std::isnan(exact[1].measured[1].error));
}

TEST_F(Study, AFrameThatTheGraphLacksIsRefused)
{
    StudyOptions o = options({{"x.steps", {"1", "2"}}});
    for (const int frame : {-1, 11}) {
        o.frames = {frame};
        try {
            study(file_, toys(), o);
            FAIL() << "frame " << frame << " was accepted";
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find("has frames 0 to 10"), std::string::npos)
                << error.what();
        }
    }
    o.frames = {0, 10};
    EXPECT_EQ(study(file_, toys(), o).size(), 2u);
}

// Node 0 steps to frame 4 in 8 s, 2 s a frame; node 1 draws that frame alone, in 3 s.
TEST(StudyReport, TheTimeOfAFrameCountsTheFramesThatASimulationStepsThrough)
{
    std::vector<runtime::Run> runs;
    for (int f = 1; f <= 4; ++f) runs.push_back({.node = 0, .frame = f, .seconds = 2});
    runs.push_back({.node = 1, .frame = 4, .seconds = 3});
    EXPECT_EQ(seconds_a_frame(runs, {4}), 2 + 3);
    // What is the same at some of the frames runs fewer times than it is asked for.
    EXPECT_EQ(seconds_a_frame({{.node = 2, .frame = 1, .seconds = 6}}, {1, 2, 3}), 2);
    EXPECT_EQ(seconds_a_frame({}, {1}), 0);
}

TEST_F(Study, AFailedTrialIsReportedAndTheOthersGoOn)
{
    StudyOptions o = options({{"x.broken", {"true", "false"}}});
    o.exact = 1;
    const std::vector<Trial> trials = study(file_, toys(), o);
    EXPECT_NE(trials[0].failure.find("told to break"), std::string::npos);
    EXPECT_TRUE(std::isnan(trials[0].error));
    EXPECT_FALSE(trials[0].best);
    EXPECT_TRUE(trials[1].failure.empty());
    EXPECT_TRUE(trials[1].best);
}

// Stopped when its first trial is told, and before it begins.
TEST_F(Study, AStudyThatWasStoppedGivesNoTable)
{
    for (const bool at_once : {false, true}) {
        std::stop_source source;
        if (at_once) source.request_stop();
        StudyOptions o = options({{"x.steps", {"1", "2", "64"}}});
        o.cook.stop = source.get_token();
        std::vector<Trial> told;
        EXPECT_THROW(study(file_, toys(), o,
                           [&](const Trial& t) {
                               told.push_back(t);
                               source.request_stop();
                           }),
                     graph::Cancelled);
        EXPECT_EQ(told.size(), at_once ? 0u : 1u);
        for (const Trial& t : told) EXPECT_EQ(t.failure, "");
    }
}

// A wire whose values are apart by what is no number: of one length, or not comparable.
struct Row {
    std::vector<double> x;
};
struct Rows {
    int length = 2, steps = 1;
    bool grows = false;
};
struct RowsOut {
    Row row;
};

}  // namespace study_test

namespace graph {
template <> inline constexpr const char* wire_name<study_test::Row> = "row";
}

namespace study_test {

static RowsOut rows(const Rows& in, const graph::Context& context)
{
    const int length = in.length + (in.grows && context.frame() > 5 ? 1 : 0);
    const double x = context.frame() + 1.0 / in.steps;
    return {{std::vector<double>(std::size_t(length), x)}};
}

class StudyOfRows : public Study {
protected:
    void SetUp() override
    {
        Study::SetUp();
        std::ofstream(file_) << R"({ "aspic": 1, "frames": { "first": 1, "last": 10, "fps": 10 },
            "nodes": { "x": { "type": "Rows@1" } } })";
        registry_.add("Rows", 1, rows)
            .summary("Rows of numbers.")
            .param("length", &Rows::length, "How many.")
            .param("steps", &Rows::steps, "How exact.")
            .param("grows", &Rows::grows, "Whether there is one more from frame 6 on.")
            .output("row", &RowsOut::row, "The row.")
            .reads(graph::Variable::frame);
    }
    std::vector<Trial> cook(std::vector<Vary> varied) const
    {
        StudyOptions o = options(std::move(varied));
        o.measures = {"x.row"};
        o.distances["row"] = [](const graph::Value& a, const graph::Value& b) {
            const auto &p = a.as<Row>()->x, &q = b.as<Row>()->x;
            if (p.size() != q.size()) throw std::invalid_argument("they are not as long");
            return std::abs(p[0] - q[0]);
        };
        return study(file_, registry_, o);
    }

    graph::Registry registry_;
};

TEST_F(StudyOfRows, ASettingThatCantBeComparedIsReportedAndTheOthersGoOn)
{
    const auto trials = cook({{"x.length", {"3", "2"}}, {"x.steps", {"1", "4"}}});
    ASSERT_EQ(trials.size(), 4u);
    for (const std::size_t i : {0u, 1u}) {
        EXPECT_EQ(trials[i].incomparable, "at frame 1 they are not as long");
        EXPECT_EQ(trials[i].failure, "");
        EXPECT_TRUE(std::isnan(trials[i].error) && std::isnan(trials[i].relative));
        EXPECT_FALSE(trials[i].best);
    }
    EXPECT_EQ(trials[2].incomparable, "");
    EXPECT_NEAR(trials[2].error, 0.75, 1e-12);  // 1 / 1 - 1 / 4
    EXPECT_TRUE(any_compared(trials));
    EXPECT_NE(to_csv(trials).find("not comparable: at frame 1"), std::string::npos);
    EXPECT_FALSE(any_compared(cook({{"x.length", {"3", "2"}}})));
}

TEST_F(StudyOfRows, AGrowingReferenceIsScaledByItsComparableFrames)
{
    const auto trials = cook({{"x.grows", {"true"}}, {"x.steps", {"1", "4"}}});
    EXPECT_EQ(trials[0].incomparable, "");
    EXPECT_NEAR(trials[0].relative, 0.75 / 4, 1e-12);  // it goes 4 from frame 1 to 5
    EXPECT_EQ(cook({{"x.grows", {"true", "false"}}})[0].incomparable,
              "at frame 6 they are not as long");
}

TEST_F(Study, OptionsThatMakeNoSenseAreRefusedWithAReason)
{
    StudyOptions o = options({{"x.steps", {"1"}}});
    o.measures = {"y.value"};
    EXPECT_THROW(study(file_, toys(), o), std::invalid_argument);
    o = options({{"x.stops", {"1", "2"}}});
    try {
        study(file_, toys(), o);
        FAIL() << "an unknown parameter was accepted";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("steps"), std::string::npos) << error.what();
    }
}

// What the command leaves and says; the program that plots is not asked.
struct Asked {
    int exit;
    std::string out, err;
};

class StudyCommand : public Study {
protected:
    Asked run(std::vector<std::string> words, std::stop_token stop = {}) const
    {
        std::vector<std::string> args{"study",          file_.string(), "--out",
                                      folder_.string(), "--measure",    "x.value",
                                      "--no-disk-cache"};
        args.insert(args.end(), words.begin(), words.end());
        std::ostringstream out, err;
        Console console{out, err, false, std::move(stop), {}, "1.2.3"};
        const int exit = run_command_line(args, toys(), console);
        return {exit, out.str(), err.str()};
    }
};

static bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

TEST_F(StudyCommand, OneSettingAloneIsRefused)
{
    const Asked alone = run({"--vary", "x.steps=4"});
    EXPECT_EQ(alone.exit, exit_usage);
    EXPECT_TRUE(has(alone.err, "at least two settings")) << alone.err;
    EXPECT_TRUE(has(alone.err, "--reference")) << alone.err;
    EXPECT_EQ(run({"--vary", "x.steps=4", "--reference", "0.5"}).exit, exit_ok);
}

TEST_F(StudyCommand, AReferenceIsANumberOrASetting)
{
    for (const char* wrong : {"abc", "1.5m", "nan", "1e999"}) {
        const Asked said = run({"--vary", "x.steps=1,2", std::string("--reference=") + wrong});
        EXPECT_EQ(said.exit, exit_usage) << wrong;
        EXPECT_TRUE(has(said.err, "expected a number, node.parameter=value")) << said.err;
        EXPECT_TRUE(has(said.err, wrong)) << said.err;
    }
}

TEST_F(StudyCommand, VariesAVariableAndTakesOneAsReference)
{
    std::ofstream(file_) << R"({ "aspic": 1, "frames": { "last": 5 }, "variables": { "n": 1 },
        "nodes": { "x": { "type": "Decay@1", "params": { "steps": "=n" } } } })";
    const Asked said = run({"--vary", "n=1,2", "--reference", "n=4"});
    EXPECT_EQ(said.exit, exit_ok) << said.err;
    EXPECT_TRUE(has(said.err, "n=2: error ")) << said.err;
    const Asked unknown = run({"--vary", "n=1,2", "--reference", "m=4"});
    EXPECT_EQ(unknown.exit, exit_usage);
    EXPECT_TRUE(has(unknown.err, "no variable 'm'")) << unknown.err;
}

TEST_F(StudyCommand, WhatCouldNotBeComparedIsAFailure)
{
    const Asked broken = run({"--vary", "x.broken=true,false", "--vary", "x.steps=1,2"});
    EXPECT_EQ(broken.exit, exit_failed) << broken.err;
    const Asked all = run({"--vary", "x.broken=true", "--reference", "0.5"});
    EXPECT_EQ(all.exit, exit_failed);
    EXPECT_TRUE(has(all.err, "no setting has an error above 0")) << all.err;
    EXPECT_FALSE(has(all.err, "gnuplot")) << all.err;
}

TEST_F(StudyCommand, LeavesNoPlotOfAnEarlierStudy)
{
    std::ofstream(folder_ / "study.png") << "an earlier one";
    const Asked said = run({"--vary", "x.steps=1,2"});
    EXPECT_TRUE(has(said.err, "warning: no plot was made")) << said.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "study.png"));
}

TEST_F(StudyCommand, AStudyThatWasStoppedIsExit130AndWritesNothing)
{
    std::stop_source source;
    source.request_stop();
    const Asked said = run({"--vary", "x.steps=1,2"}, source.get_token());
    EXPECT_EQ(said.exit, exit_cancelled) << said.err;
    EXPECT_EQ(said.out + said.err, "");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "study.csv"));
}

TEST_F(StudyCommand, TheValuesStandBesideTheErrors)
{
    const Asked said = run({"--vary", "x.steps=1,2", "--measure", "x.row"});
    EXPECT_EQ(said.exit, exit_usage);  // the toys know no distance of rows
    const Asked values = run({"--vary", "x.steps=1,2", "--measure", "x.value"});
    EXPECT_TRUE(has(values.err, " ms per frame; x.value 0.348678, x.value 0.348678 (error "))
        << values.err;
}

TEST_F(StudyCommand, AReferenceOfZeroGivesNoRelativeError)
{
    const Asked said = run({"--vary", "x.steps=1,2", "--reference", "0"});
    EXPECT_FALSE(has(said.err, "nan")) << said.err;
    EXPECT_TRUE(has(said.err, "no relative error")) << said.err;
    EXPECT_EQ(said.exit, exit_failed);
}

TEST_F(StudyCommand, AMisspelledOutputGetsTheNearestName)
{
    const Asked port = run({"--vary", "x.steps=1,2", "--look", "x.valu"});
    EXPECT_TRUE(has(port.err, "'x' (Decay) has no such output; did you mean 'value'?")) << port.err;
    const Asked node = run({"--vary", "x.steps=1,2", "--look", "y.value"});
    EXPECT_TRUE(has(node.err, "there is no node 'y'; available: 'x'")) << node.err;
    const Asked number = run({"--vary", "x.steps=1,2", "--look", "x.value"});
    EXPECT_EQ(number.exit, exit_usage);
    EXPECT_TRUE(has(number.err, "to be a picture, found type number")) << number.err;
}

TEST_F(StudyCommand, AParameterThatHasNoEffectIsShown)
{
    const Asked said = run({"--vary", "x.weight=1,2,3"});
    const std::string text = "  warning: node 'x', parameter 'weight': this has no effect while "
                             "rule is 'euler'";
    EXPECT_TRUE(has(said.err, text)) << said.err;
    SweepOptions both;
    both.varied = {parse_vary("x.rule=euler,other"), parse_vary("x.weight=2")};
    Caches caches;
    const Swept swept = sweep(file_, toys(), both, caches);
    ASSERT_EQ(swept.rows.size(), 2u);
    EXPECT_EQ(swept.rows[0].warnings.size(), 2u) << "and that one step is few";
    EXPECT_EQ(swept.rows[1].warnings.size(), 1u);
}

TEST_F(StudyCommand, WarningsOfNodesAreShown)
{
    const Asked said = run({"--vary", "x.steps=1,2,3"});
    EXPECT_TRUE(has(said.err, "warning: 'x': one step is few")) << said.err;
    EXPECT_EQ(said.err.find("one step is few"), said.err.rfind("one step is few")) << said.err;
}

static Trial trial(const char* value, double relative, double ms)
{
    Trial t;
    t.settings = {{"x.steps", value}};
    t.error = t.relative = relative;
    t.frame_seconds = ms / 1e3;
    return t;
}

TEST(StudyReport, TheQuickestSettingWithinTheErrorIsNamed)
{
    const std::vector<Trial> trials{trial("1", 0.2, 1), trial("2", 0.009, 2), trial("4", 0.001, 4)};
    EXPECT_NE(soonest(trials, 0.01).find("within 1 %: x.steps=2"), std::string::npos)
        << soonest(trials, 0.01);
    EXPECT_NE(soonest(trials, 1e-6).find("closest is x.steps=4"), std::string::npos)
        << soonest(trials, 1e-6);
}

// As of the mass of cubes: only what runs once takes time, and the last setting is quickest.
TEST(StudyReport, WhereNothingVariesByFrameTheTimeIsThatOfWhatRunsOnce)
{
    std::vector<Trial> trials{trial("1", 0.001, 0), trial("2", 0.02, 0), trial("3", 0.01, 0)};
    trials[0].setup_seconds = 8, trials[1].setup_seconds = 4, trials[2].setup_seconds = 2;
    EXPECT_EQ(soonest(trials, 0.05),
              "Fastest setting within 5 %: x.steps=3 (2e+03 ms in all, error 1 %).");
    mark_best(trials);
    EXPECT_TRUE(trials[0].best);
    EXPECT_FALSE(trials[1].best) << "3 is nearer and quicker";
    EXPECT_TRUE(trials[2].best);
    EXPECT_TRUE(any_to_plot(trials));
    const std::string program = plot_program(trials, "a.csv", "a.png", "a");
    EXPECT_TRUE(has(program, "set xlabel 'milliseconds in all'")) << program;
    EXPECT_TRUE(has(program, "skip 1 using 6:4 with")) << program;  // setup_ms, error_relative
    trials[0].frame_seconds = 1;
    EXPECT_TRUE(has(plot_program(trials, "a.csv", "a.png", "a"), "skip 1 using 5:4 with"));
}

TEST(StudyReport, AnApostropheInANameIsDoubledForGnuplot)
{
    const std::string program =
        plot_program({trial("1", 0.5, 1)}, "it's/a.csv", "it's/a.png", "it's: x");
    EXPECT_TRUE(has(program, "set output 'it''s/a.png'\n")) << program;
    EXPECT_TRUE(has(program, "set title 'it''s: x' noenhanced\n")) << program;
    EXPECT_TRUE(has(program, "plot 'it''s/a.csv' skip 1")) << program;
}

TEST(StudyReport, TheTableHasALineATrialAndQuotesWhatNeedsIt)
{
    std::vector<Trial> trials{trial("[1,2]", 0.5, 1)};
    trials[0].failure = "it said \"no\"";
    trials[0].warnings = {"'x': one step is few", "'x': much"};
    EXPECT_EQ(to_csv(trials),
              "\"x.steps\",error_rms,error_max,error_relative,ms_per_frame,setup_ms,best,reference,"
              "failure,warnings,first_warning\n"
              "\"[1,2]\",0.5,0,0.5,1,0,0,0,\"it said \"\"no\"\"\",2,\"'x': one step is few\"\n");
}

TEST(Vary, ValuesAreSplitOutsideBracketsAndQuotes)
{
    const Vary v = parse_vary(R"(pin.box.size=[1,2,3],"a,b",0.5)");
    EXPECT_EQ(v.target, "pin.box.size");
    EXPECT_EQ(v.values, (std::vector<std::string>{"[1,2,3]", "\"a,b\"", "0.5"}));
    const auto values = [](const char* text) { return parse_vary(text).values; };
    using Values = std::vector<std::string>;
    EXPECT_EQ(values("c.size==max(0.2, 0.1),0.25"), (Values{"=max(0.2, 0.1)", "0.25"}));
    EXPECT_EQ(values(R"(a.text="5\",6","\\",7)"), (Values{R"("5\",6")", R"("\\")", "7"}));
    EXPECT_EQ(values("a.b= 0.1, 0.2 "), (Values{"0.1", "0.2"}));
    EXPECT_EQ(parse_vary("cell=0.1,0.2").target, "cell");
    for (const char* wrong :
         {"", "a", "=1", "a=", "a.b=", "a.b=1,,2", "a.b=1, ,2", "a.b=[1,2", "a.b==max(1,2"}) {
        EXPECT_THROW(parse_vary(wrong), std::invalid_argument) << wrong;
    }
}

TEST(Vary, EveryCombinationComesOnceTheLastVaryingFastest)
{
    const auto all = combinations({{"a.x", {"1", "2"}}, {"b.y", {"p", "q", "r"}}});
    ASSERT_EQ(all.size(), 6u);
    EXPECT_EQ(describe(all[0]), "a.x=1 b.y=p");
    EXPECT_EQ(describe(all[1]), "a.x=1 b.y=q");
    EXPECT_EQ(describe(all[5]), "a.x=2 b.y=r");
    EXPECT_EQ(combinations({}).size(), 1u);
    EXPECT_THROW(combinations({{"a.x", std::vector<std::string>(200, "1")},
                               {"a.y", std::vector<std::string>(200, "1")}}),
                 std::invalid_argument);
}

}  // namespace study_test
