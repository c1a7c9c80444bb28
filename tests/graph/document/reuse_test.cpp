// Shot files and subgraphs: one graph in many places.

#include "graph/document/document.hpp"
#include "graph/document/evaluate.hpp"
#include "tests/graph/folder.hpp"
#include "tests/graph/toys.hpp"

#include <chrono>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using graph::Loaded;
using toys::Folder;

struct Project : Folder {
    Project() { std::filesystem::create_directory(path / "graphs"); }
    Loaded load(const std::string& name, const graph::LoadOptions& options = {}) const
    {
        return graph::load_file(path / "graphs" / name, toys::registry(), options);
    }
    void add(const std::string& name, const std::string& text) const
    {
        write("graphs/" + name, text);
    }
    // Problems, one a line, with file names only instead of whole paths.
    std::string told(const Loaded& loaded) const
    {
        std::string text = toys::told(loaded);
        const std::string folder = (path / "graphs").string() + "/";
        for (std::size_t at; (at = text.find(folder)) != std::string::npos;) {
            text.erase(at, folder.size());
        }
        return text;
    }
};

const graph::Node* find(const Loaded& loaded, const std::string& name)
{
    for (const graph::Node& node : loaded.graph.nodes) {
        if (node.name == name) return &node;
    }
    return nullptr;
}

std::string names(const Loaded& loaded)
{
    std::string text;
    for (const graph::Node& node : loaded.graph.nodes) text += node.name + " ";
    return text;
}

const graph::ParamValue& param(const graph::Node* node, const std::string& name)
{
    std::size_t i = 0;
    while (node->type->params.at(i).name != name) ++i;
    return node->params[i];
}
double number(const Loaded& loaded, const std::string& node, const std::string& name)
{
    return std::get<double>(param(find(loaded, node), name).is);
}

constexpr const char* oven = R"({ "aspic": 1,
  "frames": { "first": 1, "last": 48, "fps": 24 },
  "variables": { "sack": 2, "pile": "=sack * 10" },
  "nodes": {
    "mill":  { "type": "Mill@1", "params": { "weight": "=pile", "sacks": 3, "label": "rye" } },
    "knead": { "type": "Knead@1", "inputs": { "dough": "mill.dough", "salt": "mill.crumbs" },
               "params": { "time": 5 } },
    "bread": { "type": "Bake@1", "inputs": { "loaves": "knead" },
               "params": { "gas": { "pressure": 3, "burners": 2 } } },
    "scale": { "type": "Weigh@1", "inputs": { "dough": "bread" } }
  },
  "expect": [ { "value": "scale", "min": 0 } ]
})";

// ---- shots -------------------------------------------------------------------------------------

TEST(Shots, ChangeParametersFramesVariablesAndLinks)
{
    const Project project;
    project.add("bakery.json", oven);
    project.add("shots/010.json", R"({ "aspic": 1, "extends": "../bakery.json",
      "frames": { "last": 12 },
      "variables": { "sack": 3, "minutes": 7 },
      "nodes": {
        "mill":  { "params": { "label": null, "sacks": 4 } },
        "knead": { "inputs": { "salt": null }, "params": { "time": "=minutes * 2" } },
        "bread": { "params": { "gas": { "burners": 5 } } } } })");
    const Loaded shot = project.load("shots/010.json");
    ASSERT_TRUE(shot.ok()) << project.told(shot);
    EXPECT_EQ(project.told(shot), "");
    EXPECT_EQ(shot.graph.range, (graph::FrameRange{1, 12, 24}));
    // The base's own expression sees the shot's variable.
    EXPECT_EQ(number(shot, "mill", "weight"), 30);
    EXPECT_EQ(std::get<std::int64_t>(param(find(shot, "mill"), "sacks").is), 4);
    EXPECT_EQ(std::get<std::string>(param(find(shot, "mill"), "label").is), "flour");
    EXPECT_EQ(number(shot, "knead", "time"), 14);
    EXPECT_TRUE(find(shot, "knead")->inputs[1].empty());
    const auto& gas = std::get<graph::ParamValues>(param(find(shot, "bread"), "gas").is);
    EXPECT_EQ(std::get<double>(gas[0].is), 3);  // the block's other parameter stays
    EXPECT_EQ(std::get<std::int64_t>(gas[1].is), 5);
    EXPECT_TRUE(shot.graph.expectations.empty());  // they were the base's
    EXPECT_EQ(shot.graph.documents.size(), 2u);
}

// As RFC 7386 has it: what the base does not state, null leaves as it is.
TEST(Shots, NullIsTheDefaultWhereTheBaseStatesNoParameters)
{
    const Project project;
    project.add("mill.json", R"({ "aspic": 1, "nodes": {
        "mill": { "type": "Mill@1" },
        "bread": { "type": "Bake@1", "inputs": { "loaves": "mill.dough" } } } })");
    project.add("shot.json", R"({ "aspic": 1, "extends": "mill.json", "nodes": {
        "mill": { "params": { "label": null, "sacks": 4 } },
        "bread": { "params": { "gas": { "pressure": null, "burners": 5 } } } } })");
    const Loaded shot = project.load("shot.json");
    EXPECT_EQ(project.told(shot), "");
    EXPECT_EQ(std::get<std::string>(param(find(shot, "mill"), "label").is), "flour");
    EXPECT_EQ(std::get<std::int64_t>(param(find(shot, "mill"), "sacks").is), 4);
}

TEST(Shots, MayLeaveParametersOfTheBaseWithoutEffect)
{
    const Project project;
    project.add("bakery.json", oven);
    const auto told = [&](const std::string& params, const graph::LoadOptions& options = {}) {
        project.add("shot.json", fmt::format(R"({{ "aspic": 1, "extends": "bakery.json", "nodes": {{
            "bread": {{ "params": {{ {} }} }} }} }})",
                                             params));
        return project.told(project.load("shot.json", options));
    };
    EXPECT_EQ(told(R"("oven": "wood")"), "");
    // Unless the shot says them itself, in part or whole, or hides nothing.
    constexpr const char* idle =
        "'gas': this has no effect while oven is 'wood'; it applies when oven is 'gas'";
    const std::string in_part = told("\"oven\": \"wood\",\n\"gas\": { \"burners\": 5 }");
    EXPECT_NE(in_part.find(idle), std::string::npos) << in_part;
    EXPECT_TRUE(in_part.starts_with("shot.json:3:21: ")) << in_part;
    EXPECT_NE(told(R"("wood": { "kind": "oak" })").find("'wood': this has no effect"),
              std::string::npos);
    // So does a setting of the command line.
    graph::LoadOptions options;
    options.sets = {{"bread.oven", "wood"}};
    EXPECT_EQ(told("", options), "");
    options.sets.push_back({"bread.gas.burners", "4"});
    EXPECT_NE(told("", options).find(idle), std::string::npos);
    // And a shot of a shot.
    project.add("shot.json", R"({ "aspic": 1, "extends": "bakery.json" })");
    project.add("last.json", R"({ "aspic": 1, "extends": "shot.json", "nodes": {
        "bread": { "params": { "oven": "wood" } } } })");
    EXPECT_EQ(project.told(project.load("last.json")), "");
}

TEST(Shots, ReplaceAddAndRemoveNodesOverSeveralLevels)
{
    const Project project;
    project.add("bakery.json", oven);
    project.add("sequence.json", R"({ "aspic": 1, "extends": "bakery.json", "nodes": {
      "bread": { "type": "Knead@1", "inputs": { "dough": "knead" } },
      "scale": null } })");
    project.add("shot.json", R"({ "aspic": 1, "extends": "sequence.json", "nodes": {
      "bread": { "params": { "time": 1 } },
      "weigher": { "type": "Weigh@1", "inputs": { "dough": "bread" } } },
      "expect": [ { "value": "weigher.weight", "max": 100 } ] })");
    const Loaded shot = project.load("shot.json");
    ASSERT_TRUE(shot.ok()) << project.told(shot);
    EXPECT_EQ(names(shot), "mill knead bread weigher ");
    EXPECT_EQ(find(shot, "bread")->type->name, "Knead");
    EXPECT_EQ(number(shot, "bread", "time"), 1);
    EXPECT_EQ(shot.graph.expectations.size(), 1u);
}

TEST(Shots, SayInWhichFileAMistakeStands)
{
    const Project project;
    project.add("bakery.json", oven);
    project.add("a.json", R"({ "aspic": 1, "extends": "bakery.json",
  "nodes": { "mil": { "params": {} } } })");
    EXPECT_EQ(project.told(project.load("a.json")),
              "a.json:2:14: error: the base document has no node 'mil'; did you mean "
              "'mill'?\n");
    project.add("b.json", R"({ "aspic": 1, "extends": "bakery.json",
  "nodes": { "mill": null, "knead": { "params": { "time": -1 } } } })");
    EXPECT_EQ(project.told(project.load("b.json")),
              "b.json:2:59: error: node 'knead', parameter 'time': expected a number of at least 0 "
              "s, found -1\n"
              "bakery.json:6:56: error: node 'knead', input 'dough': there is no node 'mill'; "
              "available: 'bread' and 'scale'\n"
              "bakery.json:6:78: error: node 'knead', input 'salt': there is no node 'mill'; "
              "available: 'bread' and 'scale'\n");
    project.add("c.json", R"({ "aspic": 1, "extends": "bakry.json" })");
    EXPECT_NE(project.told(project.load("c.json")).find("c.json:1:26: error: file not found"),
              std::string::npos);
    EXPECT_NE(project.told(project.load("c.json")).find("did you mean 'bakery.json'?"),
              std::string::npos);
    project.add("d.json", R"({ "aspic": 1, "extends": "/etc/passwd" })");
    EXPECT_NE(project.told(project.load("d.json")).find("outside the project folder"),
              std::string::npos);
}

TEST(Shots, ThatExtendEachOtherAreRefused)
{
    const Project project;
    project.add("a.json", R"({ "aspic": 1, "extends": "b.json" })");
    project.add("b.json", R"({ "aspic": 1, "extends": "a.json" })");
    EXPECT_EQ(project.told(project.load("a.json")),
              "b.json:1:26: error: these documents form a loop: a.json -> b.json -> a.json; "
              "found \"a.json\"\n");
    for (int i = 0; i < 40; ++i) {
        project.add(fmt::format("n{}.json", i),
                    fmt::format(R"({{ "aspic": 1, "extends": "n{}.json" }})", i + 1));
    }
    EXPECT_NE(project.told(project.load("n0.json")).find("more than 16 levels of nested documents"),
              std::string::npos);
}

// ---- subgraphs ---------------------------------------------------------------------------------

constexpr const char* loaf = R"({ "aspic": 1, "doc": "Kneads and bakes one loaf.",
  "subgraph": {
    "version": 2,
    "inputs":  { "dough": { "to": "work.dough", "doc": "What to bake." },
                 "salt":  { "to": "work.salt", "optional": true } },
    "outputs": { "bread": { "from": "oven.bread", "doc": "The loaf." } },
    "params":  { "time":    { "to": "work.time", "default": 8, "doc": "Of kneading." },
                 "burners": { "to": "oven.gas.burners" },
                 "rest":    { "to": "variables.rest" } } },
  "variables": { "rest": 2 },
  "nodes": {
    "work": { "type": "Knead@1", "params": { "raisins": [ { "size": "=rest" } ] } },
    "oven": { "type": "Bake@1", "inputs": { "loaves": ["work"] } } } })";

TEST(Subgraphs, StandForTheNodesInside)
{
    const Project project;
    project.add("assets/loaf.json", loaf);
    project.add("g.json", R"({ "aspic": 1, "variables": { "long": 30 }, "nodes": {
      "mill":  { "type": "Mill@1" },
      "loaf":  { "type": "assets/loaf.json@2", "inputs": { "dough": "mill.dough" },
                 "params": { "time": "=long", "burners": 7, "rest": "=long / 10" } },
      "other": { "type": "assets/loaf.json", "inputs": { "dough": "loaf", "salt": "mill.crumbs" } },
      "scale": { "type": "Weigh@1", "inputs": { "dough": "other.bread" } } } })");
    const Loaded g = project.load("g.json");
    ASSERT_TRUE(g.ok()) << project.told(g);
    EXPECT_EQ(names(g), "mill loaf/work loaf/oven other/work other/oven scale ");
    EXPECT_EQ(number(g, "loaf/work", "time"), 30);  // by the outer document's variable
    EXPECT_EQ(number(g, "other/work", "time"), 8);  // the subgraph's default
    EXPECT_EQ(g.graph.documents.size(), 2u) << "what it was read from, the subgraph's file too";
    const auto gas = [&](const char* node) {
        return std::get<graph::ParamValues>(param(find(g, node), "gas").is);
    };
    EXPECT_EQ(std::get<std::int64_t>(gas("loaf/oven")[1].is), 7);
    EXPECT_EQ(std::get<std::int64_t>(gas("other/oven")[1].is), 4);  // the node's own default
    const auto raisin = [&](const char* node) {
        const auto& list = std::get<graph::ParamValues>(param(find(g, node), "raisins").is);
        return std::get<double>(std::get<graph::ParamValues>(list.at(0).is)[1].is);
    };
    EXPECT_EQ(raisin("loaf/work"), 3);
    EXPECT_EQ(raisin("other/work"), 2);
    EXPECT_EQ(g.graph.nodes[3].inputs[0][0].node, 2u);  // other/work takes loaf/oven
    EXPECT_EQ(g.graph.nodes[3].inputs[1].size(), 1u);
    EXPECT_EQ(g.graph.nodes[5].inputs[0][0].node, 4u);
    EXPECT_EQ(g.graph.nodes[1].place.line, 12);  // in the subgraph's file
}

TEST(Subgraphs, KnowTheFramesPerSecondInDefaultsOfTheirVariables)
{
    const Project project;
    std::string text = loaf;
    const std::string_view old = R"("rest":    { "to": "variables.rest" })";
    text.replace(text.find(old), old.size(),
                 R"("rest": { "to": "variables.rest", "default": "=fps / 8" })");
    project.add("loaf.json", text);
    project.add("g.json", R"({ "aspic": 1, "frames": { "fps": 48 }, "nodes": {
      "mill": { "type": "Mill@1" },
      "loaf": { "type": "loaf.json", "inputs": { "dough": "mill.dough" } } } })");
    const Loaded g = project.load("g.json");
    ASSERT_TRUE(g.ok()) << project.told(g);
    const auto& list = std::get<graph::ParamValues>(param(find(g, "loaf/work"), "raisins").is);
    EXPECT_EQ(std::get<double>(std::get<graph::ParamValues>(list.at(0).is)[1].is), 6);
    project.add("g.json", R"({ "aspic": 1, "frames": { "fps": 48, "last": "=fps" } })");
    EXPECT_EQ(project.told(project.load("g.json")).find("did you mean 'fps'?"), std::string::npos);
}

TEST(Subgraphs, NameVariablesThatTheyDoNotDeclare)
{
    const Project project;
    std::string text = loaf;
    const std::string_view old = "variables.rest";
    text.replace(text.find(old), old.size(), "variables.rset");
    project.add("loaf.json", text);
    for (const char* const params : {"", R"(, "params": { "rest": 3 })"}) {
        project.add("g.json", std::string(R"({ "aspic": 1, "nodes": { "mill": { "type": "Mill@1" },
          "loaf": { "type": "loaf.json", "inputs": { "dough": "mill.dough" })") +
                                  params + " } } }");
        const std::string told = project.told(project.load("g.json"));
        EXPECT_NE(told.find("the subgraph has no variable 'rset'"), std::string::npos) << told;
        EXPECT_NE(told.find("did you mean 'rest'?"), std::string::npos) << told;
        EXPECT_NE(told.find("loaf.json:"), std::string::npos) << told;
    }
}

TEST(Subgraphs, NestAndAreReachedByOverrides)
{
    const Project project;
    project.add("loaf.json", loaf);
    project.add("two.json", R"({ "aspic": 1, "subgraph": {
        "inputs": { "dough": { "to": ["a.dough", "b.dough"] } },
        "outputs": { "bread": { "from": "all.bread" }, "first": { "from": "a" } },
        "params": { "time": { "to": ["a.time", "b.time"] } } },
      "nodes": {
        "a": { "type": "loaf.json@2" }, "b": { "type": "loaf.json@2" },
        "all": { "type": "Bake@1", "inputs": { "loaves": ["a.bread", "b.bread"] } } } })");
    project.add("g.json", R"({ "aspic": 1, "nodes": { "mill": { "type": "Mill@1" },
      "two": { "type": "two.json@1", "inputs": { "dough": "mill.dough" }, "params": { "time": 3 } },
      "scale": { "type": "Weigh@1", "inputs": { "dough": "two.first" } } } })");
    graph::LoadOptions options;
    options.sets = {graph::parse_override("two.time=4"),
                    graph::parse_override("two/b/work.time=5")};
    const Loaded g = project.load("g.json", options);
    ASSERT_TRUE(g.ok()) << project.told(g);
    EXPECT_EQ(names(g), "mill two/a/work two/a/oven scale two/b/work two/b/oven two/all ");
    EXPECT_EQ(number(g, "two/a/work", "time"), 4);
    EXPECT_EQ(number(g, "two/b/work", "time"), 5);
    EXPECT_EQ(find(g, "scale")->inputs[0][0].node, 2u);
}

TEST(Subgraphs, SeveralInputsMayFeedOneList)
{
    const Project project;
    project.add("s.json", R"({ "aspic": 1, "subgraph": {
        "inputs": { "a": { "to": "oven.loaves" }, "b": { "to": "oven.loaves" } },
        "outputs": { "bread": { "from": "oven" } } },
      "nodes": { "oven": { "type": "Bake@1" } } })");
    project.add("g.json", R"({ "aspic": 1, "nodes": { "m": { "type": "Mill@1" }, "n": { "type":
      "Mill@1" }, "s": { "type": "s.json", "inputs": { "a": "m.dough", "b": "n.dough" } } } })");
    const Loaded g = project.load("g.json");
    ASSERT_TRUE(g.ok()) << project.told(g);
    EXPECT_EQ(find(g, "s/oven")->inputs[0].size(), 2u);
}

TEST(Subgraphs, SayWhatIsWrongAndInWhichFile)
{
    const Project project;
    project.add("loaf.json", loaf);
    const auto says = [&](const std::string& node) {
        project.add("g.json", fmt::format("{{ \"aspic\": 1, \"nodes\": {{ \"m\": {{ \"type\": "
                                          "\"Mill@1\" }},\n\"l\": {} }} }}",
                                          node));
        return project.told(project.load("g.json"));
    };
    EXPECT_EQ(
        says(R"({ "type": "loaf.json" })"),
        "g.json:2:1: error: node 'l', input 'dough': this input is required but not linked\n");
    EXPECT_EQ(says(R"({ "type": "loaf.json", "inputs": { "dough": "m.dough", "slat": "m" } })"),
              "g.json:2:61: error: node 'l', input 'slat': the subgraph has no such input; did you "
              "mean 'salt'?\n");
    EXPECT_EQ(says(R"({ "type": "loaf.json", "inputs": { "dough": "m.crumbs" } })"),
              "g.json:2:50: error: node 'l/work', input 'dough': expected a wire of type dough, "
              "found 'm.crumbs' of type crumbs; candidates: 'm.dough' and 'l/oven.bread'\n");
    EXPECT_EQ(says(R"({ "type": "loaf.json", "inputs": { "dough": "m.dough" },
  "params": { "tiem": 3 } })"),
              "g.json:3:15: error: node 'l', parameter 'tiem': the subgraph has no such parameter; "
              "did you mean 'time'?\n");
    EXPECT_EQ(says(R"({ "type": "loaf.json", "inputs": { "dough": "m.dough" },
  "params": { "burners": 70 } })"),
              "g.json:3:26: error: node 'l/oven', parameter 'gas.burners': expected a whole number "
              "from 1 to 8, found 70\n");
    EXPECT_EQ(says(R"({ "type": "loaf.json@3", "inputs": { "dough": "m.dough" } })"),
              "g.json:2:16: error: node 'l': expected version 2, found \"loaf.json@3\"\n");
    EXPECT_EQ(says(R"({ "type": "loaf.json@1", "inputs": { "dough": "m.dough" } })"),
              "g.json:2:16: warning: node 'l': expected version 2, found \"loaf.json@1\"; check "
              "that the newer version still does the same\n");
    EXPECT_EQ(says(R"({ "type": "laof.json" })"),
              "g.json:2:16: error: node 'l': file not found; found \"laof.json\"; did you "
              "mean 'loaf.json'?\n");
    EXPECT_EQ(says(R"({ "type": "g.json" })"),
              "g.json:2:16: error: node 'l': these documents form a loop: g.json -> g.json; "
              "found \"g.json\"\n");
}

TEST(Subgraphs, ThatMultiplyWithoutEndAreStopped)
{
    const Project project;
    // Each level holds ten of the next: 10^9 nodes would come of it.
    for (int level = 0; level < 9; ++level) {
        std::string nodes;
        for (int i = 0; i < 10; ++i) {
            nodes += fmt::format(R"({}"n{}": {{ "type": "level{}.json" }})", i > 0 ? ", " : "", i,
                                 level + 1);
        }
        project.add(fmt::format("level{}.json", level),
                    fmt::format(R"({{ "aspic": 1, "subgraph": {{}}, "nodes": {{ {} }} }})", nodes));
    }
    project.add("level9.json", R"({ "aspic": 1, "subgraph": {}, "nodes": {} })");
    graph::LoadOptions options;
    options.max_nodes = 5000;
    EXPECT_NE(project.told(project.load("level0.json", options)).find("more than 5000 nodes"),
              std::string::npos);
}

TEST(Subgraphs, AreCountedBeforeTheyAreExpanded)
{
    const Project project;
    // Three of the next in each of 16: 3 + 9 + ... + 3^16 = (3^17 - 3) / 2 nodes, of which a third
    // are in each node of the first. Expanding the million that is allowed took 45 s.
    for (int level = 0; level < 16; ++level) {
        std::string nodes;
        for (int i = 0; i < 3; ++i) {
            nodes += fmt::format(R"({}"n{}": {{ "type": "level{}.json" }})", i > 0 ? ", " : "", i,
                                 level + 1);
        }
        project.add(fmt::format("level{}.json", level),
                    fmt::format(R"({{ "aspic": 1, "subgraph": {{}}, "nodes": {{ {} }} }})", nodes));
    }
    project.add("level16.json", R"({ "aspic": 1, "subgraph": {}, "nodes": {} })");
    const auto began = std::chrono::steady_clock::now();
    EXPECT_EQ(project.told(project.load("level0.json")),
              "level0.json:1:42: error: node 'n0': more than 1000000 nodes once subgraphs are "
              "expanded; found 2.15e+07 in this node\n");
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(2));
}

}  // namespace
