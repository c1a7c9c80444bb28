#include "graph/tools/format.hpp"

#include "graph/tools/difference.hpp"
#include "tests/graph/toys.hpp"

#include <gtest/gtest.h>

namespace {

std::string formatted(const std::string& text)
{
    graph::Problems problems;
    return graph::format_document(text, "toy.json", problems).value_or("(not JSON)");
}

constexpr const char* untidy = R"(// A bakery.
{"nodes":{"mill":{"params":{"weight":2.50,"sacks":3.0, // not four
"label":"rye"},"type":"Mill@1"},
  // The kneading.
  "knead" : {"type":"Knead@1", "params": {"raisins":[{"size":1},{"size":2,"at":[0,1,1e-3]},{"size":3,"at":[0,1,2]},{"size":4}]},
  /* two */ "inputs":{"dough":"mill.dough"}}},
 "frames":{"last":48.0,"first":1}, "aspic" : /* version */ 1,
 "ui": { /* nothing */ }
 // the last word
}
// after all
)";

TEST(Format, GivesTheCanonicalTextWithItsComments)
{
    EXPECT_EQ(formatted(untidy), R"(// A bakery.
{
  /* version */
  "aspic": 1,
  "frames": { "first": 1, "last": 48 },
  "nodes": {
    "mill": {
      "type": "Mill@1",
      "params": {
        "weight": 2.5,
        "sacks": 3,  // not four
        "label": "rye"
      }
    },
    // The kneading.
    "knead": {
      "type": "Knead@1",
      /* two */
      "inputs": { "dough": "mill.dough" },
      "params": {
        "raisins": [
          { "size": 1 },
          { "size": 2, "at": [0, 1, 0.001] },
          { "size": 3, "at": [0, 1, 2] },
          { "size": 4 }
        ]
      }
    }
  },
  "ui": {
    /* nothing */
  }
  // the last word
}
// after all
)");
}

TEST(Format, OfItsOwnResultChangesNothing)
{
    const std::string once = formatted(untidy);
    EXPECT_EQ(formatted(once), once);
}

TEST(Format, ChangesNoMeaning)
{
    const graph::Loaded a = toys::load(untidy), b = toys::load(formatted(untidy));
    ASSERT_TRUE(a.ok() && b.ok()) << toys::told(a) << toys::told(b);
    EXPECT_EQ(graph::difference(a.graph, b.graph), std::vector<std::string>());
}

TEST(Format, KeepsTheDigitsOfWholeNumbersBeyond64Bits)
{
    const std::string text = R"({
  "aspic": 1,
  "ui": { "ids": [18446744073709551615, -9223372036854775809, 1e+300, 9223372036854775807, 1e+15] }
}
)";
    EXPECT_EQ(formatted(text), text);
}

TEST(Format, LosesNoCommentWhereverItStands)
{
    const std::string text =
        R"({ "aspic": 1, "nodes": { "m": { "type": "Mill@1", "params": { "place": [1, 2, 3] } } } })";
    for (std::size_t at = 0; at <= text.size(); ++at) {
        for (const char* comment : {"/* here */", "// here\n"}) {
            const std::string with = text.substr(0, at) + comment + text.substr(at);
            const std::string result = formatted(with);
            if (result == "(not JSON)") continue;  // inside of a token
            EXPECT_NE(result.find("here"), std::string::npos) << with;
            EXPECT_EQ(formatted(result), result) << with;
        }
    }
}

TEST(Format, RefusesWhatIsNoDocument)
{
    EXPECT_EQ(formatted("{"), "(not JSON)");
    EXPECT_EQ(formatted("{ \"a\": 1, \"a\": 2 }"), "(not JSON)");
}

// ---- difference --------------------------------------------------------------------------------

std::vector<std::string> between(const std::string& a, const std::string& b)
{
    const graph::Loaded x = toys::load(a), y = toys::load(b);
    EXPECT_TRUE(x.ok() && y.ok()) << toys::told(x) << toys::told(y);
    return graph::difference(x.graph, y.graph);
}

TEST(Difference, SeesMeaningAndNotNotation)
{
    const std::string a = R"({ "aspic": 1, "nodes": {
      "m": { "type": "Mill@1", "params": { "weight": 1, "tint": "#fff", "sacks": 6 } },
      "w": { "type": "Weigh@1", "inputs": { "dough": "m.dough" } } } })";
    const std::string b = R"({ "aspic": 1, "variables": { "two": 2 }, "ui": 3, "nodes": {
      "w": { "type": "Weigh@1", "inputs": { "dough": "m.dough" } }, // moved
      "m": { "type": "Mill@1", "params": { "sacks": "=3 * two", "label": "flour" } } } })";
    EXPECT_EQ(between(a, b), std::vector<std::string>());
}

TEST(Difference, NamesEveryChange)
{
    const std::string a = R"({ "aspic": 1, "frames": { "last": 48 }, "nodes": {
      "k": { "type": "Knead@1", "inputs": { "dough": "m.dough" },
             "params": { "raisins": [ { "size": 1 } ] } },
      "b": { "type": "Bake@1", "inputs": { "loaves": ["k", "m.dough"] } },
      "m": { "type": "Mill@1", "params": { "weight": 1, "place": [0, 1, 2] } },
      "w": { "type": "Weigh@1", "inputs": { "dough": "m.dough" } } },
      "expect": [ { "value": "w", "min": 1 } ] })";
    const std::string b = R"({ "aspic": 1, "frames": { "last": 12 }, "nodes": {
      "k": { "type": "Knead@1", "inputs": { "dough": "m.dough", "salt": "m.crumbs" },
             "params": { "raisins": [ { "size": 2 }, {} ] } },
      "b": { "type": "Bake@1", "inputs": { "loaves": ["m.dough", "k"] },
             "params": { "gas": { "burners": 2 } } },
      "m": { "type": "Mill@1", "params": { "weight": "=frame", "place": [0, "=time", 2] } },
      "v": { "type": "Weigh@1", "inputs": { "dough": "m.dough" } } } })";
    EXPECT_EQ(between(a, b), (std::vector<std::string>{
                                 "frames: 1 to 48 at 24 fps -> 1 to 12 at 24 fps",
                                 "~ b <- loaves: k.dough, m.dough -> m.dough, k.dough",
                                 "~ b.gas.burners: 4 -> 2",
                                 "~ k <- salt: nothing -> m.crumbs",
                                 "~ k.raisins: 1 elements -> 2 elements",
                                 "~ k.raisins.0.size: 1 -> 2",
                                 "~ k.raisins.1.at: nothing -> [0, 0, 0]",
                                 "~ k.raisins.1.size: nothing -> 1",
                                 "~ m.place: [0, 1, 2] -> [0, =time, 2]",
                                 "~ m.weight: 1 -> =frame",
                                 "+ v (Weigh@1)",
                                 "- w (Weigh@1)",
                                 "- expects w.weight from 1 to inf at 48",
                             }));
}

TEST(Dot, HasANodeAndAnEdgeForEach)
{
    const graph::Loaded loaded = toys::load(R"({ "aspic": 1, "nodes": {
      "m": { "type": "Mill@1" }, "b": { "type": "Bake@1", "inputs": { "loaves": "m.dough" } } } })");
    const std::string dot = graph::dot_text(loaded.graph);
    EXPECT_NE(dot.find("  \"m\" [label=\"m\\nMill@1\"]\n"), std::string::npos) << dot;
    EXPECT_NE(dot.find("  \"b\" [label=\"b\\nBake@1\", peripheries=2]\n"), std::string::npos);
    EXPECT_NE(dot.find("  \"m\" -> \"b\" [label=\"dough\", tooltip=\"dough to loaves\"]\n"),
              std::string::npos);
}

}  // namespace
