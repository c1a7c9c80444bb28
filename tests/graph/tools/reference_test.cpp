#include "graph/tools/reference.hpp"

#include "graph/tools/schema.hpp"
#include "tests/graph/toys.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sstream>

namespace {

TEST(Reference, APageHasEveryTypePortParameterAndItsSentence)
{
    const std::string page = graph::reference_page(toys::registry());
    for (const auto& [name, type] : toys::registry().types()) {
        EXPECT_NE(page.find("\n## " + name + "\n\n" + type.summary), std::string::npos);
        for (const auto& port : type.inputs) EXPECT_NE(page.find(port.doc), std::string::npos);
        for (const auto& port : type.outputs) EXPECT_NE(page.find(port.doc), std::string::npos);
        for (const auto& p : type.params) EXPECT_NE(page.find(p.doc), std::string::npos);
    }
    for (const char* row :
         {"| `weight` | number | `1` | 0 to 100 kg | Of a sack. |",
          "| `raisins[].size` | number | `1` | from 0 | How large it is. |",
          "| `gas.burners` | whole number | `4` | 1 to 8 | How many are lit. |",
          "| `gas` | block |  |  | The gas oven. Only while oven is gas. |",
          "| `grain` | choice | `\"wheat\"` | wheat, rye, oats | What is ground. |",
          "| `loaves` | dough | any number of links | What to bake. |",
          "| `salt` | crumbs | optional | What to strew in. |",
          "| `crumbs` | crumbs | What was left over. |", "| [Bake](#bake) | Bakes loaves. |"}) {
        EXPECT_NE(page.find(row), std::string::npos) << row << "\nnot in\n" << page;
    }
}

TEST(Reference, OfOneTypeFitsATerminal)
{
    EXPECT_EQ(graph::reference_text(*toys::registry().find("Knead"), 60),
              "Knead@1  Works the dough.\n"
              "\n"
              "inputs\n"
              "  dough (dough, required)\n"
              "      What to work.\n"
              "  salt (crumbs, optional)\n"
              "      What to strew in.\n"
              "\n"
              "outputs\n"
              "  dough (dough)\n"
              "      The worked dough.\n"
              "\n"
              "parameters\n"
              "  raisins (list; default [])\n"
              "      Raisins to put in.\n"
              "  raisins[].at (vector, m; default [0, 0, 0])\n"
              "      Where it sits.\n"
              "  raisins[].size (number, from 0; default 1)\n"
              "      How large it is.\n"
              "  time (number, from 0 s; default 10)\n"
              "      How long.\n");
    EXPECT_EQ(graph::reference_list(toys::registry()), "Bake   Bakes loaves.\n"
                                                       "Knead  Works the dough.\n"
                                                       "Mill   Grinds grain.\n"
                                                       "Weigh  Weighs dough.\n");
}

TEST(Schema, SaysTypesRangesChoicesAndLinks)
{
    const auto schema = nlohmann::json::parse(graph::schema_text(toys::registry()));
    EXPECT_EQ(schema["$schema"], "http://json-schema.org/draft-07/schema#");
    const auto& node = schema["definitions"]["node"];
    EXPECT_EQ(node["properties"]["type"]["anyOf"][2]["const"], "Mill@1");
    const auto& mill = node["allOf"][2];
    EXPECT_EQ(mill["if"]["properties"]["type"]["pattern"], "^Mill(@1)?$");
    const auto& params = mill["then"]["properties"]["params"];
    EXPECT_EQ(params["additionalProperties"], false);
    const auto& weight = params["properties"]["weight"];
    EXPECT_EQ(weight["default"], 1.0);
    EXPECT_EQ(weight["description"], "Of a sack. In kg.");
    EXPECT_EQ(weight["anyOf"][0]["type"], "number");
    EXPECT_EQ(weight["anyOf"][0]["maximum"], 100.0);
    EXPECT_EQ(weight["anyOf"][1]["$ref"], "#/definitions/expression");
    EXPECT_EQ(weight["anyOf"][2]["required"], nlohmann::json::array({"keys"}));
    EXPECT_EQ(params["properties"]["grain"]["enum"],
              nlohmann::json::array({"wheat", "rye", "oats"}));
    const auto& raisins = node["allOf"][1]["then"]["properties"]["params"]["properties"]["raisins"];
    EXPECT_EQ(raisins["items"]["properties"]["size"]["anyOf"][0]["minimum"], 0.0);
    const auto& loaves = node["allOf"][0]["then"]["properties"]["inputs"]["properties"]["loaves"];
    EXPECT_EQ(loaves["allOf"][0]["$ref"], "#/definitions/links");
}

TEST(Reference, IsSearchedForAWord)
{
    const auto names = [](std::string_view word) {
        std::istringstream lines(graph::reference_list(toys::registry(), word));
        std::vector<std::string> found;
        for (std::string line; std::getline(lines, line);) {
            found.push_back(line.substr(0, line.find(' ')));
        }
        return found;
    };
    using Names = std::vector<std::string>;
    EXPECT_EQ(names("").size(), toys::registry().types().size());
    // Knead and Weigh say it of themselves, the others of a port.
    EXPECT_EQ(names("DOUGH"), (Names{"Knead", "Weigh", "Mill"}));
    EXPECT_EQ(names("flour maker"), Names{"Mill"}) << "a synonym";
    EXPECT_EQ(names("rye"), Names{"Mill"}) << "a choice";
    EXPECT_EQ(names("spaceship"), Names{});
    EXPECT_EQ(graph::reference_list(toys::registry(), "burners"), "Bake   gas.burners\n");
}

}  // namespace
