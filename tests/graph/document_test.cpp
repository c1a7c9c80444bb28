#include "graph/document.hpp"

#include "graph/evaluate.hpp"
#include "tests/graph/toys.hpp"

#include <gtest/gtest.h>

namespace {

using graph::Loaded;
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

}  // namespace
