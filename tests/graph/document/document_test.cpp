#include "graph/document/document.hpp"

#include "graph/document/evaluate.hpp"
#include "graph/tools/difference.hpp"
#include "tests/graph/folder.hpp"
#include "tests/graph/toys.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>

namespace {

using graph::Loaded;
using toys::Folder;
using toys::load;
using toys::told;

constexpr const char* bakery = R"({ "aspic": 1,
  "doc": "A bakery.",
  "frames": { "first": 1, "last": 49, "fps": 24 },
  "variables": { "sack": 2.5, "half": "=sack / 2" },  // kilograms
  "nodes": {
    "bread": { "type": "Bake@1", "inputs": { "loaves": ["work", "mill.dough"] },
               "params": { "oven": "gas", "gas": { "burners": 2 } } },
    "work":  { "type": "Knead@1", "inputs": { "dough": "mill.dough", "salt": "mill.crumbs" },
               "params": { "raisins": [ { "at": [0, "=time", 0] }, { "size": 3 } ] } },
    "mill":  { "type": "Mill@1",
               "params": { "weight": "=half", "sacks": 4, "tint": "#ff0000", "grain": "rye",
                           "place": { "keys": [[1, [0, 0, 0]], [49, [4, 0, 2]]],
                                      "interpolation": "linear" } } },
    "scale": { "type": "Weigh@1", "inputs": { "dough": "bread" } }
  },
  "expect": [ { "value": "scale.weight", "frame": [1, 49], "near": 20, "percent": 10 } ]
})";

TEST(Document, AGoodOneLoadsWithEveryKindOfValue)
{
    const Loaded loaded = load(bakery);
    ASSERT_TRUE(loaded.ok()) << told(loaded);
    EXPECT_EQ(told(loaded), "");
    const graph::Graph& g = loaded.graph;
    ASSERT_EQ(g.nodes.size(), 4u);
    EXPECT_EQ(g.nodes[0].name, "mill");
    EXPECT_EQ(g.nodes[1].name, "work");
    EXPECT_EQ(g.nodes[2].name, "bread");
    EXPECT_EQ(g.nodes[3].name, "scale");
    ASSERT_EQ(g.nodes[2].inputs[0].size(), 2u);
    EXPECT_EQ(g.nodes[2].inputs[0][0].node, 1u);
    EXPECT_EQ(g.nodes[2].inputs[0][1].node, 0u);
    EXPECT_EQ(g.nodes[1].inputs[1][0].output, 1u);

    // Frame 25 is half-way between keys 1 and 49, one second after the first.
    const auto params = graph::evaluate(g.nodes[0], 25, 1.0);
    EXPECT_EQ(std::get<double>(params[0].is), 1.25);
    EXPECT_EQ(std::get<std::int64_t>(params[1].is), 4);
    const auto place = std::get<std::array<double, 3>>(params[4].is);
    EXPECT_DOUBLE_EQ(place[0], 2);
    EXPECT_DOUBLE_EQ(place[1], 0);
    EXPECT_DOUBLE_EQ(place[2], 1);
    EXPECT_EQ(g.nodes[0].animated.size(), 2u);  // y stands still: a constant

    const auto work = graph::evaluate(g.nodes[1], 25, 1.0);
    const auto& raisins = std::get<graph::ParamValues>(work[0].is);
    ASSERT_EQ(raisins.size(), 2u);
    const auto& first = std::get<graph::ParamValues>(raisins[0].is);
    EXPECT_EQ((std::get<std::array<double, 3>>(first[0].is)[1]), 1.0);

    ASSERT_EQ(g.expectations.size(), 1u);
    EXPECT_EQ(g.expectations[0].value.node, 3u);
    EXPECT_EQ(g.expectations[0].frames, (std::vector<int>{1, 49}));
    EXPECT_DOUBLE_EQ(g.expectations[0].min, 18);
    EXPECT_DOUBLE_EQ(g.expectations[0].max, 22);
}

std::string reading(const std::string& recipe)
{
    return fmt::format(R"({{ "aspic": 1, "nodes": {{
  "m": {{ "type": "Mill@1", "params": {{ "recipe": "{}" }} }} }} }})",
                       recipe);
}

TEST(Document, OrderOfNodesDoesNotDependOnTheirOrderInTheText)
{
    const std::string a = R"("a": { "type": "Knead@1", "inputs": { "dough": "z.dough" } })";
    const std::string b = R"("b": { "type": "Weigh@1", "inputs": { "dough": "a" } })";
    const std::string m = R"("m": { "type": "Mill@1" })";
    const std::string z = R"("z": { "type": "Mill@1" })";
    const auto names = [](const std::string& nodes) {
        const Loaded loaded = load("{ \"aspic\": 1, \"nodes\": { " + nodes + " } }");
        std::string all;
        for (const graph::Node& node : loaded.graph.nodes) all += node.name;
        return all;
    };
    EXPECT_EQ(names(a + "," + b + "," + m + "," + z), "zabm");
    EXPECT_EQ(names(z + "," + m + "," + b + "," + a), "zabm");
}

TEST(Document, AChainAHundredThousandDeepLoads)
{
    constexpr int depth = 100'000;
    std::string text = R"({ "aspic": 1, "nodes": { "n0": { "type": "Mill@1" })";
    for (int i = depth; i > 0; --i) {
        text += fmt::format(
            R"(, "n{}": {{ "type": "Knead@1", "inputs": {{ "dough": "n{}.dough" }} }})", i, i - 1);
    }
    const Loaded loaded = load(text + " } }");
    ASSERT_TRUE(loaded.ok());
    ASSERT_EQ(loaded.graph.nodes.size(), depth + 1u);
    for (int i = 0; i <= depth; ++i) {
        EXPECT_EQ(loaded.graph.nodes[static_cast<std::size_t>(i)].name, fmt::format("n{}", i));
    }
}

TEST(Document, AThousandMistakesAreEnough)
{
    std::string text = R"({ "aspic": 1, "nodes": { "n": { "type": "Mill@1" })";
    for (int i = 0; i < 5000; ++i) text += fmt::format(R"(, "n{}": 3)", i);
    const Loaded loaded = load(text + " } }");
    EXPECT_EQ(loaded.problems.size(), 1001u);
    EXPECT_EQ(describe(loaded.problems.back()), "error: 4000 more problems are not shown");
}

TEST(Document, NestingBombsAndLargeFilesAreRefused)
{
    const std::string deep(200'000, '[');
    EXPECT_EQ(told(load(deep)), "toy.json:1:65: error: brackets nested deeper than 64\n");
    EXPECT_EQ(told(load("{ \"aspic\": 1, \"ui\": " + deep)),
              "toy.json:1:84: error: brackets nested deeper than 64\n");
    graph::LoadOptions small;
    small.max_bytes = 10;
    EXPECT_EQ(told(load(bakery, small)), "toy.json: error: the document is too large: " +
                                             std::to_string(std::string(bakery).size()) +
                                             " bytes, limit 10\n");
}

TEST(Document, ASequenceOfFilesIsOneAFrame)
{
    const Folder folder, elsewhere;
    for (const char* name : {"r.0001.txt", "r.0002.txt", "r.0007.txt", "r.12345.txt", "r.8.txt",
                             "r.0009.txt.bak", "####.txt"}) {
        folder.write(name, "flour");
    }
    std::filesystem::create_symlink(elsewhere.write("secret.txt", "secret"),
                                    folder.path / "r.0003.txt");
    const auto load_reading = [&](const std::string& recipe) {
        return graph::load_file(folder.write("g.json", reading(recipe)), toys::registry());
    };
    const auto file_at = [&](const Loaded& loaded, int frame) {
        return std::get<std::string>(evaluate(loaded.graph.nodes[0], frame, 0)[7].is);
    };
    const auto wrong_at = [&](const Loaded& loaded, int frame) -> std::string {
        try {
            evaluate(loaded.graph.nodes[0], frame, 0);
        } catch (const graph::Failure& failure) {
            return failure.problem.message;
        }
        return "";
    };

    const Loaded loaded = load_reading("r.####.txt");
    ASSERT_TRUE(loaded.ok()) << told(loaded);
    const std::string before = (folder.path / "r.").string();
    for (const int frame : {1, 2, 7, 12345}) {
        EXPECT_EQ(file_at(loaded, frame), fmt::format("{}{:04}.txt", before, frame));
    }
    EXPECT_EQ(wrong_at(loaded, 8), "at frame 8: file not found: " + before +
                                       "0008.txt; the sequence has files from frame 1 to 12345");
    EXPECT_NE(wrong_at(loaded, 3).find("is outside the project folder"), std::string::npos);
    EXPECT_EQ(graph::values_of(loaded.graph.nodes[0]).at("recipe"), "r.####.txt");
    EXPECT_TRUE(graph::files_of(loaded.graph.nodes[0]).empty());
    EXPECT_EQ(graph::files_at(loaded.graph.nodes[0], 7).at(0), before + "0007.txt");
    EXPECT_TRUE(graph::files_at(loaded.graph.nodes[0], 8).empty());

    EXPECT_TRUE(load_reading("####.txt").graph.nodes[0].animated.empty()) << "a file of that name";
    const Loaded none = load_reading("q.####.txt");
    ASSERT_EQ(none.problems.size(), 1u);
    EXPECT_EQ(none.problems[0].message, "file not found: " + (folder.path / "q.####.txt").string());

    // A path as Windows has it.
    folder.write("pantry/r.txt", "flour");
    const Loaded slashed = load_reading("pantry\\\\r.txt");
    ASSERT_EQ(slashed.problems.size(), 1u);
    EXPECT_EQ(slashed.problems[0].suggestion, "write '/' in place of '\\'");
    const Loaded pantry = load_reading("pantry");
    ASSERT_EQ(pantry.problems.size(), 1u);
    EXPECT_EQ(pantry.problems[0].expected, "a file");
    EXPECT_EQ(pantry.problems[0].found, "the folder " + (folder.path / "pantry").string());
}

TEST(Document, FilesAreReadBesideTheDocumentAndInsideOfTheProject)
{
    const Folder folder, elsewhere;
    folder.write("project/graphs/deep/recipe.txt", "flour");
    elsewhere.write("secret.txt", "secret");
    std::filesystem::create_symlink(elsewhere.path / "secret.txt",
                                    folder.path / "project/graphs/link.txt");
    const auto load_reading = [&](const std::string& recipe,
                                  const graph::LoadOptions& options = {}) {
        const auto file = folder.write("project/graphs/g.json", reading(recipe));
        return graph::load_file(file, toys::registry(), options);
    };
    const auto says = [&](const std::string& recipe) {
        const Loaded loaded = load_reading(recipe);
        return loaded.problems.empty() ? "" : loaded.problems[0].message;
    };

    const Loaded good = load_reading("deep/recipe.txt");
    ASSERT_TRUE(good.ok()) << told(good);
    EXPECT_EQ(good.graph.root, folder.path / "project");
    EXPECT_EQ(std::get<std::string>(good.graph.nodes[0].params[7].is),
              (folder.path / "project/graphs/deep/recipe.txt").string());
    EXPECT_EQ(says("../graphs/./deep/recipe.txt"), "");
    EXPECT_EQ(says(""), "");

    const std::string outside =
        "this path is outside the project folder " + (folder.path / "project").string();
    EXPECT_EQ(says("../../../etc/passwd"), outside);
    EXPECT_EQ(says("/etc/passwd"), outside);
    EXPECT_EQ(says((elsewhere.path / "secret.txt").string()), outside);
    EXPECT_EQ(says("link.txt"), outside);
    EXPECT_EQ(says("nowhere\\u0000.txt"), "not a valid path");
    EXPECT_EQ(says("two\\nlines.txt"), "not a valid path");
    const Loaded anywhere = load_reading("link.txt", {.allow_outside = true});
    EXPECT_TRUE(anywhere.ok());
    EXPECT_TRUE(anywhere.graph.root.empty()) << "files that it names may lie anywhere too";
    EXPECT_TRUE(
        load_reading((elsewhere.path / "secret.txt").string(), {.allow_outside = true}).ok());
    EXPECT_FALSE(load_reading("deep/recipe.txt", {.root = folder.path / "project/other"}).ok());

    const Loaded missing = load_reading("deep/recipy.txt");
    ASSERT_EQ(missing.problems.size(), 1u);
    EXPECT_EQ(missing.problems[0].suggestion, "did you mean 'recipe.txt'?");
    EXPECT_EQ(load_reading("deep/recipe.obj").problems[0].suggestion, "did you mean 'recipe.txt'?");
    EXPECT_EQ(load_reading("recipe.txt").problems[0].suggestion, "did you mean 'deep/recipe.txt'?");
    EXPECT_EQ(load_reading("deep").problems[0].expected, "a file");
}

TEST(Document, OutputPathsStayInTheOutputFolder)
{
    const auto writing = [](const std::string& report, bool allow) {
        graph::LoadOptions options;
        options.allow_outside = allow;
        return load("{ \"aspic\": 1, \"nodes\": { \"b\": { \"type\": \"Bake@1\", \"params\": { "
                    "\"report\": \"" +
                        report + "\" } } } }",
                    options)
            .ok();
    };
    EXPECT_TRUE(writing("a/b.txt", false));
    EXPECT_TRUE(writing("a/../b.####.png", false));
    EXPECT_FALSE(writing("../b.txt", false));
    EXPECT_FALSE(writing("a\\nfile b.txt", true));
    EXPECT_FALSE(writing("a/../../b.txt", false));
    EXPECT_FALSE(writing("/tmp/b.txt", false));
    EXPECT_TRUE(writing("/tmp/b.txt", true));
}

TEST(Document, AFileThatIsNotThereNamesItsNeighbour)
{
    const Folder folder;
    folder.write("chair.json", "{}");
    const Loaded loaded = graph::load_file(folder.path / "chiar.json", toys::registry());
    ASSERT_EQ(loaded.problems.size(), 1u);
    EXPECT_EQ(describe(loaded.problems[0]), (folder.path / "chiar.json").string() +
                                                ": error: file not found; did you mean "
                                                "'chair.json'?");
    EXPECT_FALSE(graph::load_file(folder.path, toys::registry()).ok());
}

TEST(Overrides, ReachBlocksListsAndComponents)
{
    graph::LoadOptions options;
    for (const char* text :
         {"mill.sacks=7", "mill.label=rye flour", "mill.weight==frame * 2", "bread.gas.burners=3",
          "work.raisins.1.size=9", "work.raisins.0.at.2=5", "mill.recipe="}) {
        options.sets.push_back(graph::parse_override(text));
    }
    const Loaded loaded = load(bakery, options);
    ASSERT_TRUE(loaded.ok()) << told(loaded);
    const auto mill = graph::evaluate(loaded.graph.nodes[0], 3, 0);
    EXPECT_EQ(std::get<double>(mill[0].is), 6);
    EXPECT_EQ(std::get<std::int64_t>(mill[1].is), 7);
    EXPECT_EQ(std::get<std::string>(mill[3].is), "rye flour");
    const auto bread = std::get<graph::ParamValues>(loaded.graph.nodes[2].params[1].is);
    EXPECT_EQ(std::get<std::int64_t>(bread[1].is), 3);
    const auto work =
        std::get<graph::ParamValues>(graph::evaluate(loaded.graph.nodes[1], 1, 0)[0].is);
    EXPECT_EQ(std::get<double>(std::get<graph::ParamValues>(work[1].is)[1].is), 9);
    EXPECT_EQ((std::get<std::array<double, 3>>(std::get<graph::ParamValues>(work[0].is)[0].is)[2]),
              5);
}

TEST(Overrides, TakeNumbersAsAShellHasThem)
{
    const auto weight = [](const std::string& value) {
        graph::LoadOptions options;
        options.sets.push_back(graph::parse_override("mill.weight=" + value));
        const Loaded loaded = load(bakery, options);
        EXPECT_TRUE(loaded.ok()) << told(loaded);
        return std::get<double>(graph::evaluate(loaded.graph.nodes[0], 1, 0)[0].is);
    };
    EXPECT_EQ(weight(".5"), 0.5);
    EXPECT_EQ(weight("+.5e1"), 5);
    EXPECT_EQ(weight("2."), 2);
    EXPECT_EQ(weight("2.e0"), 2);
    graph::LoadOptions options;
    options.sets.push_back(graph::parse_override("work.raisins.0.at=[.5, -.25,+1.]"));
    const Loaded loaded = load(bakery, options);
    ASSERT_TRUE(loaded.ok()) << told(loaded);
    const auto work =
        std::get<graph::ParamValues>(graph::evaluate(loaded.graph.nodes[1], 1, 0)[0].is);
    EXPECT_EQ((std::get<std::array<double, 3>>(std::get<graph::ParamValues>(work[0].is)[0].is)),
              (std::array{0.5, -0.25, 1.0}));
}

TEST(Overrides, ThatAreWrongSayWhich)
{
    const auto says = [](const char* text) {
        graph::LoadOptions options;
        options.sets.push_back(graph::parse_override(text));
        return told(load(bakery, options));
    };
    EXPECT_EQ(says("mil.sacks=7"),
              "--set mil.sacks=7: error: there is no node 'mil'; did you mean 'mill'?\n");
    EXPECT_EQ(says("mill.sakcs=7"),
              "--set mill.sakcs=7: error: node 'mill', parameter 'sakcs': Mill has no such "
              "parameter; did you mean 'sacks'?\n");
    EXPECT_EQ(says("mill.sacks=0"),
              "--set mill.sacks=0: error: node 'mill', parameter 'sacks': expected a whole number "
              "from 1 to 1000, found 0\n");
    EXPECT_EQ(says("work.raisins.2.size=1"),
              "--set work.raisins.2.size=1: error: node 'work': the list has no such element; "
              "expected an index below 2, found 2\n");
    EXPECT_THROW(graph::parse_override("mill"), std::invalid_argument);
    EXPECT_THROW(graph::parse_override("mill=3"), std::invalid_argument);
    EXPECT_THROW(graph::parse_override(".a=3"), std::invalid_argument);
    EXPECT_THROW(graph::parse_override("mill.=3"), std::invalid_argument);
}

TEST(Overrides, MakeTheFirstElementOfAListThatIsNotStated)
{
    const auto says = [](const char* set) {
        graph::LoadOptions options;
        options.sets.push_back(graph::parse_override(set));
        std::string text = bakery;
        const std::string raisins = R"("raisins": [ { "at": [0, "=time", 0] }, { "size": 3 } ])";
        text.erase(text.find(raisins), raisins.size());
        return told(load(text, options));
    };
    EXPECT_EQ(says("work.raisins.0.size=1"), "");
    EXPECT_NE(says("work.raisins.1.size=1"), "");
    EXPECT_NE(says("work.0=1"), "");
}

TEST(Variables, FromOutsideReplaceTheDocumentsOwn)
{
    graph::LoadOptions options;
    options.variables = {{"sack", 8}};
    const Loaded loaded = load(bakery, options);
    ASSERT_TRUE(loaded.ok()) << told(loaded);
    EXPECT_EQ(std::get<double>(loaded.graph.nodes[0].params[0].is), 4);  // half a sack
    EXPECT_EQ(loaded.variables, (graph::Variables{{"sack", 8}, {"half", 4}}));
    options.variables = {{"sack", 8}, {"sack", 2}};
    EXPECT_EQ(load(bakery, options).variables.front().second, 2) << "the later";
    options.variables = {{"sak", 8}};
    EXPECT_EQ(told(load(bakery, options)),
              "toy.json: error: the document declares no variable 'sak'; did you mean 'sack'?\n");
}

TEST(Evaluate, RefusesWhatAFrameTakesOutOfItsLimits)
{
    const Loaded loaded = load(R"json({ "aspic": 1, "frames": { "last": 200 }, "nodes": {
  "m": { "type": "Mill@1", "params": { "weight": "=frame", "sacks": "=3 / (frame - 5)" } } } })json");
    ASSERT_TRUE(loaded.ok()) << told(loaded);
    const graph::Node& m = loaded.graph.nodes[0];
    const auto says = [&](int frame) -> std::string {
        try {
            graph::evaluate(m, frame, 0);
        } catch (const graph::Failure& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(says(6), "");
    EXPECT_EQ(says(101),
              "toy.json:2:50: error: node 'm', parameter 'weight': at frame 101; expected a number "
              "from 0 to 100 kg, found 101 from =frame");
    EXPECT_EQ(says(5), "toy.json:2:69: error: node 'm', parameter 'sacks': at frame 5; expected a "
                       "number from 1 to 1000, found inf from =3 / (frame - 5)");
}

TEST(Document, ColoursAreLinearHoweverTheyAreWritten)
{
    const auto tint = [](const std::string& text) {
        const Loaded loaded = load(fmt::format(R"({{ "aspic": 1, "nodes": {{
  "m": {{ "type": "Mill@1", "params": {{ "tint": {} }} }} }} }})",
                                               text));
        return std::get<std::array<double, 3>>(loaded.graph.nodes.at(0).params[5].is);
    };
    const auto grey = tint("\"#808080\"");  // 128/255 of sRGB is 0.21586 of light
    EXPECT_NEAR(grey[0], 0.21586, 1e-5);
    EXPECT_EQ(tint("\"#FfF\""), (std::array<double, 3>{1, 1, 1}));
    EXPECT_EQ(tint("\"#00f\""), (std::array<double, 3>{0, 0, 1}));
    EXPECT_EQ(tint("[0.25, 0.5, 1]"), (std::array<double, 3>{0.25, 0.5, 1}));
}

TEST(Document, CutOffAnywhereItIsAnErrorAndNeverACrash)
{
    const std::string text = bakery;
    for (std::size_t n = 0; n < text.size(); ++n) {
        EXPECT_FALSE(load(text.substr(0, n)).ok()) << n;
    }
}

TEST(Document, FlippedBytesNeverCrashIt)
{
    std::mt19937 random(1);
    for (int round = 0; round < 3000; ++round) {
        std::string text = bakery;
        for (unsigned k = 0; k <= random() % 4; ++k) {
            text[random() % text.size()] = static_cast<char>(random());
        }
        const Loaded loaded = load(text);
        for (const graph::Problem& p : loaded.problems) EXPECT_FALSE(describe(p).empty());
        for (const graph::Node& node : loaded.graph.nodes) {
            try {
                static_cast<void>(graph::evaluate(node, 3, 0.5));
            } catch (const graph::Failure&) {
            }
        }
    }
}

}  // namespace
