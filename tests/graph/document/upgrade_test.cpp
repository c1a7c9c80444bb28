// Documents of older versions of node types still load, with a note of what was done to them.

#include "graph/document/document.hpp"
#include "graph/document/json.hpp"
#include "tests/graph/toys.hpp"

#include <gtest/gtest.h>

namespace {

using graph::Json;
using graph::Loaded;

// The toy types a few versions later: 2 measures in kilograms, 3 calls its output dough; kneading
// calls its input dough since version 2.
graph::Registry later_registry()
{
    graph::Registry r;
    r.add("Mill", 3, toys::mill)
        .summary("Grinds grain.")
        .upgrade(1, "pounds are kilograms now",
                 [](Json& node) {
                     Json* params = node.find("params");
                     if (!params) return;
                     graph::rename(*params, "pounds", "weight");
                     Json* weight = params->find("weight");
                     if (weight && weight->number()) weight->is = *weight->number() / 2;
                 })
        .upgrade(2, "the output meal is called dough", {}, {{"meal", "dough"}})
        .param("weight", &toys::MillIn::weight, "Of a sack.", {.min = 0, .unit = "kg"})
        .param("sacks", &toys::MillIn::sacks, "How many sacks.", {.min = 1})
        .output("dough", &toys::MillOut::dough, "All the flour.")
        .output("crumbs", &toys::MillOut::crumbs, "What was left over.");
    r.add("Knead", 2, toys::knead)
        .summary("Works the dough.")
        .upgrade(1, "the input flour is called dough",
                 [](Json& node) {
                     if (Json* inputs = node.find("inputs")) {
                         graph::rename(*inputs, "flour", "dough");
                     }
                 })
        .input("dough", &toys::KneadIn::dough, "What to work.")
        .param("time", &toys::KneadIn::time, "How long.", {.min = 0, .unit = "s"})
        .output("dough", &toys::DoughOut::dough, "The worked dough.");
    r.add("Scale", 4, toys::weigh)
        .summary("Weighs dough.")
        .input("dough", &toys::WeighIn::dough, "What to weigh.")
        .output("weight", &toys::WeighOut::weight, "Its weight in kg.");
    return r;
}

const std::filesystem::path old_files = std::filesystem::path(ASPIC_SOURCE_DIR) / "tests/graph/old";

TEST(Upgrade, KeptFilesOfEveryVersionLoadToTheSameGraph)
{
    const graph::Registry registry = later_registry();
    const Loaded one = graph::load_file(old_files / "knead_1.json", registry);
    const Loaded two = graph::load_file(old_files / "knead_2.json", registry);
    ASSERT_TRUE(one.ok()) << toys::told(one);
    ASSERT_TRUE(two.ok()) << toys::told(two);
    ASSERT_EQ(one.graph.nodes.size(), 2u);
    for (const Loaded* loaded : {&one, &two}) {
        EXPECT_EQ(std::get<double>(loaded->graph.nodes[0].params[0].is), 10);
        EXPECT_EQ(std::get<std::int64_t>(loaded->graph.nodes[0].params[1].is), 2);
        ASSERT_EQ(loaded->graph.nodes[1].inputs[0].size(), 1u);
        EXPECT_EQ(loaded->graph.nodes[1].inputs[0][0].output, 0u);
    }
    ASSERT_EQ(one.problems.size(), 3u);
    EXPECT_EQ(two.problems.size(), 2u);
    EXPECT_EQ(one.problems[0].severity, graph::Severity::note);
    EXPECT_EQ(one.problems[0].message, "Mill@1 is read as Mill@2: pounds are kilograms now");
    EXPECT_EQ(one.problems[1].message, "Mill@2 is read as Mill@3: the output meal is called dough");
    EXPECT_EQ(one.problems[0].place.line, 2);
    EXPECT_EQ(one.problems[2].place.line, 3);
}

TEST(Upgrade, WithoutAStepIsAnError)
{
    const graph::Registry registry = later_registry();
    const Loaded loaded = graph::load_text(
        R"({ "aspic": 1, "nodes": { "s": { "type": "Scale@3" } } })", "toy.json", registry);
    EXPECT_EQ(toys::told(loaded),
              "toy.json:1:41: error: node 's': expected Scale of version 4, found version 3; "
              "version 3 is no longer supported\n");
}

TEST(Upgrade, MeetsStrangeNodesWithoutHarm)
{
    const graph::Registry registry = later_registry();
    for (const char* params : {"3", "[]", "{ \"pounds\": \"=frame\" }", "null"}) {
        const Loaded loaded = graph::load_text(
            std::string(R"({ "aspic": 1, "nodes": { "m": { "type": "Mill@1", "params": )") +
                params + " } } }",
            "toy.json", registry);
        EXPECT_FALSE(loaded.problems.empty());
    }
}

}  // namespace
