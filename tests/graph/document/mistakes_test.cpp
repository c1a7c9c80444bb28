// Every kind of mistake in a document: what is said of it, and the exact place.

#include "graph/document/document.hpp"
#include "graph/document/evaluate.hpp"
#include "tests/graph/toys.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using graph::Loaded;
using toys::load;
using toys::told;

struct Mistake {
    std::string text;  // with ^ where the problem is to be placed
    std::string says;  // the line without the place
};

// The text without its mark, and the place of the mark as "toy.json:2:5: ".
std::pair<std::string, std::string> unmark(const std::string& text)
{
    const std::size_t at = text.find('^');
    if (at == std::string::npos) return {text, "toy.json:1:1: "};
    int line = 1, column = 1;
    for (std::size_t i = 0; i < at; ++i) {
        if (text[i] == '\n') {
            ++line;
            column = 1;
        } else if ((static_cast<unsigned char>(text[i]) & 0xC0) != 0x80) {
            ++column;  // a character, of however many bytes
        }
    }
    return {text.substr(0, at) + text.substr(at + 1),
            fmt::format("toy.json:{}:{}: ", line, column)};
}

void expect_each(const std::vector<Mistake>& mistakes)
{
    for (const Mistake& m : mistakes) {
        const auto [text, place] = unmark(m.text);
        EXPECT_EQ(told(load(text)), place + m.says + "\n") << text;
    }
}

// A document of these nodes, each mistake on a line of its own.
std::string nodes(const std::string& text)
{
    return "{ \"aspic\": 1, \"nodes\": {\n" + text + "\n} }";
}

// A Mill called m with these parameters.
std::string mill(const std::string& params)
{
    return nodes("\"m\": { \"type\": \"Mill@1\", \"params\": { " + params + " } }");
}

TEST(Mistakes, OfJsonItself)
{
    expect_each({
        {"^", "error: invalid JSON: while parsing value - unexpected end of input; expected "
              "'[', '{', or a literal; the file ends too early; is it complete?"},
        {"{ \"aspic\": 1,\n  \"nodes\": {^",
         "error: invalid JSON: while parsing object key - unexpected end of input; expected "
         "string literal; the file ends too early; is it complete?"},
        {"{ \"aspic\": 1, ^}",
         "error: invalid JSON: while parsing object key - unexpected "
         "'}'; expected string literal; remove the comma before the closing bracket"},
        {"{ \"aspic\": ^tru }",
         "error: invalid JSON: while parsing value - invalid literal; did you mean true?"},
        {"{ \"aspic\": ^True }",
         "error: invalid JSON: while parsing value - invalid literal; did you mean true?"},
        {"{ \"aspic\": ^None }",
         "error: invalid JSON: while parsing value - invalid literal; did you mean null?"},
        {"{ \"aspic\": ^mesh }", "error: invalid JSON: while parsing value - invalid literal; text "
                                 "stands in double quotes: \"mesh\""},
        {"{ \"aspic\": 1\n ^\"nodes\": {} }",
         "error: invalid JSON: while parsing object - unexpected string literal; expected '}'; a "
         "comma is missing before it"},
        {"{ \"aspic\": [1 ^2] }", "error: invalid JSON: while parsing array - unexpected number "
                                  "literal; expected ']'; a comma is missing before it"},
        {"{ \"aspic\": 1 }\n^{}", "error: invalid JSON: while parsing value - unexpected '{'; "
                                  "expected end of input"},
        {"{ \"aspic\": ^1e999 }", "error: invalid JSON: number overflow parsing '1e999'"},
        {"{ \"aspic\": 1, \"doc\": \"a^\xFF\" }",
         "error: invalid JSON: while parsing value - invalid string: ill-formed UTF-8 byte"},
        {"{ \"aspic\": 1, \"nodes\": {},\n ^\"nodes\": {} }",
         "error: duplicate key 'nodes', first on line 1; remove one of them"},
        {"{ \"aspic\": 1, \"nodes\": {}, \"ui\": { \"a\": 1, ^\"a\": 2 } }",
         "error: duplicate key 'a', first on line 1; remove one of them"},
        {"// a comment\n/* and\nanother */ { \"aspic\": 1, \"nodes\": {}, ^\"node\": {} }",
         "error: a graph document has no 'node'; did you mean 'nodes'?"},
        {"{ \"doc\": \"öüß 漢字\", ^\"node\": {}, \"aspic\": 1, \"nodes\": {} }",
         "error: a graph document has no 'node'; did you mean 'nodes'?"},
    });
}

TEST(Mistakes, OfAnEncodingAreToldAsThat)
{
    using namespace std::string_literals;
    for (const std::string& text :
         {"\xFF\xFE{\0\n\0"s, "\xFE\xFF\0{\0\n"s, "{\0\n\0"s, "\0{\0\n"s}) {
        EXPECT_EQ(told(load(text)), "toy.json:1:1: error: this is UTF-16; save it as UTF-8\n");
    }
}

// The parser takes a NUL for the end of a comment.
TEST(Mistakes, BehindACommentThatANulEndsAreFoundInTheirPlace)
{
    using namespace std::string_literals;
    const auto known = load("// x\0{ \"aspic\": 1,\n \"nodes\": {}, \"node\": {} }"s);
    ASSERT_EQ(known.problems.size(), 1u);
    EXPECT_EQ(known.problems[0].place.line, 2);
    EXPECT_EQ(known.problems[0].place.column, 15);
    for (const std::string& cut : {"//\0{\0"s, "{ // a \0\0"s, "// a\0{ \"b"s, "//\0"s}) {
        EXPECT_FALSE(load(cut).problems.empty());
    }
}

TEST(Mistakes, OfTheDocumentAsAWhole)
{
    expect_each({
        {"^[]", "error: expected a graph document, { \"aspic\": 1, \"nodes\": {...} }, found []"},
        {"^{ \"nodes\": {} }", "error: the format version is missing; expected "
                               "\"aspic\": 1 (the format version)"},
        {"{ \"aspic\": ^2, \"nodes\": {} }", "error: expected \"aspic\": 1 (the format version), "
                                             "found 2; the document is for a newer aspic"},
        {"{ \"aspic\": ^\"1\", \"nodes\": {} }",
         "error: expected \"aspic\": 1 (the format version), found \"1\""},
        {"^{ \"aspic\": 1 }", "error: the member \"nodes\" is missing"},
        {"{ \"aspic\": 1, \"nodes\": ^[] }",
         "error: expected an object of nodes, { \"name\": {...} }, found []"},
        {"{ \"aspic\": 1, \"nodes\": {}, \"doc\": ^3 }", "error: expected text in quotes, found 3"},
    });
}

TEST(Mistakes, OfFramesAndVariables)
{
    const auto head = [](const std::string& text) {
        return "{ \"aspic\": 1, \"nodes\": {},\n" + text + " }";
    };
    expect_each({
        {head("\"frames\": ^24"),
         "error: expected { \"first\": 1, \"last\": 120, \"fps\": 24 }, found 24"},
        {head("\"frames\": { ^\"lsat\": 3 }"),
         "error: \"frames\" has no 'lsat'; did you mean 'last'?"},
        {head("\"frames\": { \"first\": 10, \"last\": ^9 }"),
         "error: expected a last frame of at least 10, found 9"},
        {head("\"frames\": { \"first\": 1, \"last\": ^2000000 }"),
         "error: expected at most 1000000 frames, found 2000000"},
        {head("\"frames\": { \"first\": ^1.5 }"),
         "error: expected a whole number between -1e9 and 1e9, found 1.5"},
        {head("\"frames\": { \"last\": ^1e10 }"),
         "error: expected a whole number between -1e9 and 1e9, found 10000000000.0"},
        {head("\"frames\": { \"fps\": ^0 }"),
         "error: expected frames per second above 0, at most 1e6, found 0"},
        {head("\"variables\": ^[]"),
         "error: expected an object of numbers, { \"scale\": 0.02 }, found []"},
        {head("\"variables\": { ^\"sin\": 1 }"),
         "error: invalid variable name 'sin'; expected letters, digits and _, not starting with a "
         "digit, and not the name of a function or constant"},
        {head("\"variables\": { \"a\": ^\"one\" }"), "error: expected a number, found \"one\""},
        {head("\"variables\": { \"a\": \"=2 * ^b\", \"b\": 1 }"),
         "error: variable 'b' has no value here yet; define it before the variables that use it"},
        {head("\"variables\": { \"a\": \"=2 * ^c\", \"b\": 1 }"),
         "error: unknown name 'c'; "
         "available: 'frame', 'time', 'pi' and 'fps', and functions"},
        {head("\"variables\": { \"width\": 1, \"b\": \"=2 * ^widht\" }"),
         "error: unknown name 'widht'; did you mean 'width'?"},
        {head("\"variables\": { \"b\": ^\"=frame\" }"),
         "error: this number must be constant, without frame and time; found \"=frame\""},
        {head("\"variables\": { \"b\": ^\"=1 / 0\" }"),
         "error: =1 / 0 gives inf, no finite number"},
    });
}

TEST(Mistakes, OfNodesAndTheirTypes)
{
    expect_each({
        {nodes("^\"1st\": { \"type\": \"Mill@1\" }"),
         "error: invalid node name '1st'; expected letters, digits, _ and -, starting with a "
         "letter"},
        {nodes("^\"a.b\": { \"type\": \"Mill@1\" }"),
         "error: invalid node name 'a.b'; expected letters, digits, _ and -, starting with a "
         "letter"},
        {nodes("\"m\": ^\"Mill\""),
         "error: node 'm': expected { \"type\": \"...\", ... }, found \"Mill\""},
        {nodes("^\"m\": {}"),
         "error: node 'm': expected \"type\": \"Name@version\", found no type"},
        {nodes("\"m\": { \"type\": ^7 }"),
         "error: node 'm': expected \"type\": \"Name@version\", found 7"},
        {nodes("\"m\": { \"type\": ^\"Mil@1\" }"),
         "error: node 'm': unknown node type 'Mil'; did you mean 'Mill'?"},
        {nodes("\"m\": { \"type\": ^\"Flour_Maker@1\" }"),
         "error: node 'm': unknown node type 'Flour_Maker'; use 'Mill'"},
        {nodes("\"m\": { \"type\": ^\"mix@1\" }"),
         "error: node 'm': unknown node type 'mix'; use 'Knead' or 'Mill'"},
        {nodes("\"m\": { \"type\": ^\"Spaceship@1\" }"),
         "error: node 'm': unknown node type 'Spaceship'; available: 'Bake', 'Knead', 'Mill' and "
         "'Weigh'"},
        {nodes("\"m\": { \"type\": ^\"Mill@7\" }"), "error: node 'm': expected Mill of version 1, "
                                                    "found version 7; it needs a newer aspic"},
        {nodes("\"m\": { \"type\": ^\"Mill@one\" }"),
         "error: node 'm': expected \"Mill@1\", found \"Mill@one\""},
        {nodes("\"m\": { \"type\": ^\"Mill\" }"),
         "note: node 'm': no version given; read as \"Mill@1\""},
        {nodes("\"m\": { \"type\": \"Mill@1\", ^\"parms\": {} }"),
         "error: node 'm': a node has no 'parms'; did you mean 'params'?"},
        {nodes("\"m\": { \"type\": \"Mill@1\", \"doc\": ^[] }"),
         "error: node 'm': expected text in quotes, found []"},
    });
}

TEST(Mistakes, InWhatHasNoEffectAreToldAsWarnings)
{
    const graph::Loaded loaded = toys::load(R"({ "aspic": 1, "nodes": {
  "m": { "type": "Mill@1" },
  "b": { "type": "Bake@1", "inputs": { "loaves": "m.dough" }, "params": {
    "wood": { "kind": 3 },
    "oven": "wood",
    "gas": { "pressure": "=1 +", "burners": "=frame", "colour": 1 } } } } })");
    EXPECT_EQ(toys::told(loaded),
              "toy.json:4:23: error: node 'b', parameter 'wood.kind': expected text in quotes, "
              "found 3\n"
              "toy.json:6:12: warning: node 'b', parameter 'gas': this has no effect while oven is "
              "'wood'; it applies when oven is 'gas'\n"
              "toy.json:6:31: warning: node 'b', parameter 'gas.pressure': Unexpected end of "
              "expression at position 4\n"
              "toy.json:6:55: warning: node 'b', parameter 'gas.colour': 'gas' has no such "
              "parameter; available: 'pressure' and 'burners'\n");
    EXPECT_TRUE(loaded.graph.nodes.empty() || loaded.graph.nodes[1].animated.empty());
}

enum class Rise { flat, risen };
enum class Leaven { yeast, sourdough };
struct ProveIn {
    Rise rise = Rise::risen;
    Leaven leaven = Leaven::sourdough;
    double hours = 12;
};

TEST(Mistakes, InWhatHasNoEffectAreToldOfTheOutermostThatHidesIt)
{
    graph::Registry registry = toys::make_registry();
    registry
        .add(
            "Prove", 1, +[](const ProveIn&, const graph::Context&) { return toys::DoughOut{}; })
        .choice("rise", &ProveIn::rise, {"flat", "risen"}, "What it does.")
        .choice("leaven", &ProveIn::leaven, {"yeast", "sourdough"}, "By what.", {"rise", {"risen"}})
        .param("hours", &ProveIn::hours, "How long.", {}, {"leaven", {"sourdough"}})
        .output("dough", &toys::DoughOut::dough, "What rose.");
    const auto said_of = [&](const std::string& params) {
        const auto loaded = graph::load_text(
            nodes("\"p\": { \"type\": \"Prove@1\", \"params\": { " + params + " } }"), "toy.json",
            registry);
        std::string text;
        for (const auto& problem : loaded.problems) {
            if (problem.port == "hours") text += problem.message;
        }
        return text;
    };
    const std::string flat =
        "this has no effect while rise is 'flat'; it applies when rise is 'risen'";
    EXPECT_EQ(said_of("\"hours\": 3"), "");
    EXPECT_EQ(said_of("\"leaven\": \"yeast\", \"hours\": 3"),
              "this has no effect while leaven is 'yeast'; it applies when leaven is 'sourdough'");
    EXPECT_EQ(said_of("\"rise\": \"flat\", \"hours\": 3"), flat);
    EXPECT_EQ(said_of("\"rise\": \"flat\", \"leaven\": \"yeast\", \"hours\": 3"), flat);
}

TEST(Mistakes, OfLinksAreFoundBehindAnUnknownTypeToo)
{
    const graph::Loaded loaded = toys::load(R"({ "aspic": 1, "nodes": {
  "m": { "type": "Mill@1" },
  "s": { "type": "Stir@1", "inputs": {
    "one": "m.dough", "two": "m.doug", "three": ["m.crumbs", "mill.dough", 7] } },
  "k": { "type": "Knead@1", "inputs": { "dough": "s.anything" } } } })");
    EXPECT_EQ(toys::told(loaded),
              "toy.json:3:18: error: node 's': unknown node type 'Stir'; available: 'Bake', "
              "'Knead', 'Mill' and 'Weigh'\n"
              "toy.json:4:30: error: node 's', input 'two': node 'm' (Mill) has no output 'doug'; "
              "did you mean 'dough'?\n"
              "toy.json:4:62: error: node 's', input 'three': there is no node 'mill'; available: "
              "'k' and 'm'\n"
              "toy.json:4:76: error: node 's', input 'three': expected a link, \"node.output\", "
              "found 7\n");
}

TEST(Mistakes, OfParameters)
{
    expect_each({
        {nodes("\"m\": { \"type\": \"Mill@1\", \"params\": ^3 }"),
         "error: node 'm': expected an object {...}, found 3"},
        {mill("^\"wieght\": 1"), "error: node 'm', parameter 'wieght': Mill has no such parameter; "
                                 "did you mean 'weight'?"},
        {mill("\"weight\": ^\"big\""),
         "error: node 'm', parameter 'weight': expected a number from "
         "0 to 100 kg, found \"big\""},
        {mill("\"weight\": ^-1"),
         "error: node 'm', parameter 'weight': expected a number from 0 to 100 kg, found -1"},
        {mill("\"weight\": ^null"),
         "error: node 'm', parameter 'weight': expected a number from 0 to 100 kg, found null"},
        {mill("\"weight\": ^\"=60 * 2\""), "error: node 'm', parameter 'weight': expected a number "
                                           "from 0 to 100 kg, found \"=60 * 2\", which is 120"},
        {mill("\"weight\": ^\"=0 / 0\""), "error: node 'm', parameter 'weight': expected a number "
                                          "from 0 to 100 kg, found \"=0 / 0\", which is NaN"},
        {mill("\"sacks\": ^2.5"),
         "error: node 'm', parameter 'sacks': expected a whole number from "
         "1 to 1000, found 2.5"},
        {mill("\"sieve\": ^1"),
         "error: node 'm', parameter 'sieve': expected true or false, found 1"},
        {mill("\"label\": ^1"),
         "error: node 'm', parameter 'label': expected text in quotes, found 1"},
        {mill("\"place\": ^[1, 2]"), "error: node 'm', parameter 'place': expected three numbers "
                                     "[x, y, z] in m, found [1, 2]"},
        {mill("\"place\": ^\"=frame\""),
         "error: node 'm', parameter 'place': expected three numbers [x, y, z] in m, found "
         "\"=frame\"; write an expression for each component"},
        {mill("\"place\": [1, ^\"x\", 3]"), "error: node 'm', parameter 'place': expected three "
                                            "numbers [x, y, z] in m, found \"x\""},
        {mill("\"tint\": ^\"#12345\""), "error: node 'm', parameter 'tint': expected a colour, "
                                        "[r, g, b] from 0 to 1 or \"#rrggbb\", found \"#12345\""},
        {mill("\"tint\": [0, ^2, 0]"), "error: node 'm', parameter 'tint': expected a colour, "
                                       "[r, g, b] from 0 to 1 or \"#rrggbb\", found 2"},
        {mill("\"grain\": ^\"wheet\""),
         "error: node 'm', parameter 'grain': expected one of 'wheat', 'rye' and 'oats', found "
         "\"wheet\"; did you mean 'wheat'?"},
    });
}

TEST(Mistakes, OfExpressions)
{
    expect_each({
        {mill("\"weight\": \"=1 + ^wieght\""),
         "error: node 'm', parameter 'weight': unknown name 'wieght'; available: 'frame', 'time', "
         "'pi' and 'fps', and functions"},
        {mill("\"weight\": \"=^\""),
         "error: node 'm', parameter 'weight': the expression is empty"},
        {mill("\"weight\": \"=^1, 2\""),
         "error: node 'm', parameter 'weight': expected one number, found several; commas only "
         "separate function arguments"},
        {mill("\"weight\": \"=frame ^= 3\""), "error: node 'm', parameter 'weight': assignment is "
                                              "not allowed in an expression; use == to compare"},
        {mill("\"weight\": \"=2.5e0 * ^m.value + 1\""),
         "error: node 'm', parameter 'weight': an expression can't read the output 'm.value' of a "
         "node; use a variable of the document for both, or link the output to an input"},
        {mill("\"weight\": \"=2 * ^$F4 \""), "error: node 'm', parameter 'weight': unknown name "
                                             "'$F4'; the number of the frame is 'frame'"},
        {mill("\"weight\": ^\"2 * frame\""),
         "error: node 'm', parameter 'weight': expected a number from 0 to 100 kg, found \"2 * "
         "frame\"; did you mean \"=2 * frame\"?"},
        {mill("\"weight\": ^\"1.5\""),
         "error: node 'm', parameter 'weight': expected a number from 0 to 100 kg, found \"1.5\"; "
         "write 1.5 without quotes"},
        {mill("\"weight\": ^\"500 g\""), "error: node 'm', parameter 'weight': expected a number "
                                         "from 0 to 100 kg, found \"500 g\"; "
                                         "write 0.5, as this is in kg"},
        {mill("\"weight\": ^\"2 cm\""), "error: node 'm', parameter 'weight': expected a number "
                                        "from 0 to 100 kg, found \"2 cm\""},
        {mill("\"weight\": ^\"heavy\""), "error: node 'm', parameter 'weight': expected a number "
                                         "from 0 to 100 kg, found \"heavy\""},
        {mill("\"weight\": \"=1 ^§ 2\""),
         "error: node 'm', parameter 'weight': this character is not allowed in an expression"},
    });
}

TEST(Mistakes, OfKeyframes)
{
    expect_each({
        {mill("\"weight\": ^{}"),
         "error: node 'm', parameter 'weight': expected a number from 0 to 100 kg, or keyframes { "
         "\"keys\": [[frame, value], ...] }, found {}"},
        {mill("\"weight\": { \"keys\": ^[] }"),
         "error: node 'm', parameter 'weight': expected keys "
         "[[frame, value], ...], found []"},
        {mill("\"weight\": { \"keys\": [^1] }"), "error: node 'm', parameter 'weight': expected a "
                                                 "key [frame, value], found 1"},
        {mill("\"weight\": { \"keys\": [[1, 0], [^1, 2]] }"),
         "error: node 'm', parameter 'weight': expected a frame after 1, the previous key's, found "
         "1"},
        {mill("\"weight\": { \"keys\": [[1, 0], [5, ^200]] }"),
         "error: node 'm', parameter 'weight': expected a number from 0 to 100 kg, found 200"},
        {mill("\"weight\": { \"keys\": [[^\"a\", 0]] }"), "error: node 'm', parameter 'weight': "
                                                          "expected a frame number, "
                                                          "found \"a\""},
        {mill("\"weight\": { \"keys\": [[1, 0]], \"interpolation\": ^\"liner\" }"),
         "error: node 'm', parameter 'weight': expected one of 'monotone', 'smooth', 'linear' and "
         "'step', found \"liner\"; did you mean 'linear'?"},
        {mill("\"weight\": { \"keys\": [[1, 0]], ^\"interp\": 1 }"),
         "error: node 'm', parameter 'weight': keyframes have no 'interp'; available: 'keys', "
         "'interpolation', 'extend' and 'times'"},
        {mill("\"place\": { \"keys\": [[1, ^2]] }"), "error: node 'm', parameter 'place': expected "
                                                     "three numbers [x, y, z] in m, found 2"},
    });
}

TEST(Mistakes, OfBlocksAndLists)
{
    const auto bake = [](const std::string& params) {
        return nodes("\"b\": { \"type\": \"Bake@1\", \"params\": { " + params + " } }");
    };
    const auto knead = [](const std::string& params) {
        return nodes(
            "\"m\": { \"type\": \"Mill@1\" }, \"k\": { \"type\": \"Knead@1\", \"inputs\": { "
            "\"dough\": \"m.dough\" }, \"params\": { " +
            params + " } }");
    };
    expect_each({
        {bake("\"gas\": ^2"),
         "error: node 'b', parameter 'gas': expected an object {...}, found 2"},
        {bake("\"gas\": { ^\"burner\": 2 }"),
         "error: node 'b', parameter 'gas.burner': 'gas' has no "
         "such parameter; did you mean 'burners'?"},
        {bake("\"gas\": { \"burners\": ^9 }"),
         "error: node 'b', parameter 'gas.burners': expected a "
         "whole number from 1 to 8, found 9"},
        {bake("^\"burners\": 2"), "error: node 'b', parameter 'burners': Bake has no such "
                                  "parameter; did you mean 'gas.burners'?"},
        {bake("\"wood\": ^{ \"kind\": \"oak\" }"),
         "warning: node 'b', parameter 'wood': this has no effect while oven is 'gas'; it applies "
         "when oven is 'wood'"},
        {bake("\"oven\": \"wood\", \"gas\": ^{}"),
         "warning: node 'b', parameter 'gas': this has no effect while oven is 'wood'; it applies "
         "when oven is 'gas'"},
        {knead("\"raisins\": ^{}"),
         "error: node 'k', parameter 'raisins': expected a list [{...}, ...], found {}"},
        {knead("^\"size\": 1"),
         "error: node 'k', parameter 'size': Knead has no such parameter; did "
         "you mean 'raisins[].size', in each item of the list?"},
        {knead("\"raisins\": [{}, ^3]"),
         "error: node 'k', parameter 'raisins.1': expected an object {...}, found 3"},
        {knead("\"raisins\": [{ \"size\": ^-1 }]"),
         "error: node 'k', parameter 'raisins.0.size': expected a number of at least 0, found -1"},
        {knead("^\"salt\": 1"), "error: node 'k', parameter 'salt': Knead has no such parameter; "
                                "'salt' is an input: link it in \"inputs\""},
    });
}

// 1e30 Pa is "at least 1e-06 Pa" and was refused by those words.
TEST(Mistakes, ALimitThatIsLargeIsSaidAndOneOfTheStorageIsNot)
{
    graph::Param p;
    p.kind = graph::ParamKind::number;
    p.limits = {1e-6, 1e15, "Pa"};
    EXPECT_EQ(graph::expectation_of(p), "a number from 1e-06 to 1000000000000000 Pa");
    p.kind = graph::ParamKind::integer;
    for (const double storage : {2147483647.0, 4294967295.0, 9223372036854775807.0}) {
        p.limits = {1, storage, ""};
        EXPECT_EQ(graph::expectation_of(p), "a whole number of at least 1");
    }
}

TEST(Mistakes, OfLinks)
{
    const auto kneading = [](const std::string& inputs) {
        return nodes(
            "\"m\": { \"type\": \"Mill@1\" },\n\"k\": { \"type\": \"Knead@1\", \"inputs\": { " +
            inputs + " } }");
    };
    expect_each({
        {nodes("\"m\": { \"type\": \"Mill@1\" },\n^\"k\": { \"type\": \"Knead@1\" }"),
         "error: node 'k', input 'dough': this input is required but not linked; candidates: "
         "'m.dough'"},
        {nodes(
             "\"m\": { \"type\": \"Mill@1\" },\n\"k\": { \"type\": \"Knead@1\", \"inputs\": ^[] }"),
         "error: node 'k': expected an object, { \"input\": \"node.output\" }, found []"},
        {kneading("\"dough\": ^3"),
         "error: node 'k', input 'dough': expected a link, \"node.output\", found 3"},
        {kneading("\"dough\": ^\"n.dough\""),
         "error: node 'k', input 'dough': there is no node 'n'; available: 'm'"},
        {kneading("\"dough\": ^\"m.duogh\""),
         "error: node 'k', input 'dough': node 'm' (Mill) has no "
         "output 'duogh'; did you mean 'dough'?"},
        {kneading("\"dough\": ^\"m\""), "error: node 'k', input 'dough': node 'm' has several "
                                        "outputs; expected one of 'dough' and 'crumbs'"},
        {kneading("\"dough\": ^\"m.crumbs\""),
         "error: node 'k', input 'dough': expected a wire of type dough, found 'm.crumbs' of type "
         "crumbs; candidates: 'm.dough'"},
        {kneading("\"dough\": ^[\"m.dough\", \"m.dough\"]"),
         "error: node 'k', input 'dough': expected one link, \"node.output\", found [\"m.dough\", "
         "\"m.dough\"]"},
        {kneading("\"dough\": \"m.dough\", ^\"slat\": \"m.crumbs\""),
         "error: node 'k', input 'slat': Knead has no such input; did you mean 'salt'?"},
        {kneading("\"dough\": \"m.dough\", ^\"time\": 3"),
         "error: node 'k', input 'time': Knead has no such input; 'time' is a parameter: set it in "
         "\"params\""},
        {nodes("\"b\": { \"type\": \"Bake@1\", \"inputs\": { \"loaves\": [^1] } }"),
         "error: node 'b', input 'loaves': expected a link, \"node.output\", found 1"},
    });
}

TEST(Mistakes, OfCyclesAreNamedWhole)
{
    const auto knead = [](const char* name, const char* from, const char* mark = "") {
        return fmt::format(R"({}"{}": {{ "type": "Knead@1", "inputs": {{ "dough": "{}" }} }})",
                           mark, name, from);
    };
    expect_each({
        {nodes(knead("a", "a", "^")), "error: node 'a': links must not form a loop: a -> a; "
                                      "simulations read their own previous frame without a link"},
        {nodes(knead("a", "c", "^") + ",\n" + knead("b", "a") + ",\n" + knead("c", "b")),
         "error: node 'a': links must not form a loop: a -> b -> c -> a; simulations read their "
         "own previous frame without a link"},
    });
}

TEST(Mistakes, OfExpectations)
{
    const auto expecting = [](const std::string& text) {
        return "{ \"aspic\": 1, \"nodes\": { \"m\": { \"type\": \"Mill@1\" }, \"w\": { \"type\": "
               "\"Weigh@1\", \"inputs\": { \"dough\": \"m.dough\" } } },\n\"expect\": " +
               text + " }";
    };
    expect_each({
        {expecting("^{}"),
         "error: expected a list, [{ \"value\": \"node.output\", ... }], found {}"},
        {expecting("[^3]"), "error: expected { \"value\": \"node.output\", \"min\": 0 }, found 3"},
        {expecting("[^{ \"min\": 3 }]"),
         "error: expected \"value\": \"node.output\" of type number"},
        {expecting("[{ \"value\": ^\"m.dough\", \"min\": 3 }]"),
         "error: expected a wire of type number, found 'm.dough' of type dough; candidates: "
         "'w.weight'"},
        {expecting("[^{ \"value\": \"w\" }]"),
         "error: expected \"min\", \"max\", or \"near\" with either \"within\" or \"percent\""},
        {expecting("[^{ \"value\": \"w\", \"near\": 1 }]"),
         "error: expected \"min\", \"max\", or \"near\" with either \"within\" or \"percent\""},
        {expecting("[^{ \"value\": \"w\", \"min\": 2, \"max\": 1 }]"),
         "error: the lower bound 2 is above the upper bound 1"},
        {expecting("[{ \"value\": \"w\", \"min\": 2, \"frame\": ^7 }]"),
         "error: expected a frame from 1 to 1, found 7"},
        {expecting("[{ \"value\": \"w\", \"min\": 2, \"frame\": ^\"some\" }]"),
         "error: expected a frame, a list of frames, \"first\", \"last\" or \"every\", found "
         "\"some\""},
        {expecting("[{ \"value\": \"w\", \"min\": 2, ^\"frames\": 1 }]"),
         "error: an expectation has no 'frames'; did you mean 'frame'?"},
    });
}

TEST(Mistakes, OfAWholeFileAreToldTogetherInOrderOfPlace)
{
    const Loaded loaded = load(nodes(R"("k": { "type": "Knead@1", "inputs": { "dough": "nobody" },
  "params": { "time": -1, "speed": 3 } },
"m": { "type": "Mil@1" },
"w": { "type": "Weigh@1" })"));
    ASSERT_EQ(loaded.problems.size(), 5u) << told(loaded);
    EXPECT_EQ(loaded.problems[0].place.line, 2);
    EXPECT_EQ(loaded.problems[1].place.line, 3);
    EXPECT_EQ(loaded.problems[2].place.line, 3);
    EXPECT_EQ(loaded.problems[3].place.line, 4);
    EXPECT_EQ(loaded.problems[4].place.line, 5);
    EXPECT_FALSE(loaded.ok());
    EXPECT_TRUE(loaded.graph.nodes.empty());
}

TEST(Mistakes, NamesOfOtherToolsAreKnown)
{
    const std::array<std::string_view, 3> names{"bounce", "friction", "thickness"};
    EXPECT_EQ(graph::suggest("restitution", names), "did you mean 'bounce'?");
    const std::array<std::string_view, 1> young{"young"};
    EXPECT_EQ(graph::suggest("youngs_modulus", young), "did you mean 'young'?");
    EXPECT_NE(graph::suggest("restitution", young), "did you mean 'bounce'?");
    const std::array<std::string_view, 3> woods{"steel", "oak", "pine"};
    EXPECT_EQ(graph::suggest("Wood", woods), "did you mean 'oak' or 'pine'?");
}

TEST(Suggest, NamesOfALongListOnlyWhatIsAkin)
{
    std::vector<std::string_view> names = {"Ball",  "Carry", "Copies", "Embed",  "Figure",
                                           "Force", "Modes", "Patch",  "Plane",  "Points",
                                           "Pin",   "Roll",  "Sample", "Shrink", "Skin"};
    const std::string text = graph::suggest("Plain", names);
    EXPECT_EQ(text.find("available: 'Plane', 'Pin'"), 0u) << text;
    EXPECT_NE(text.find(" and 13 more"), std::string::npos) << text;
    EXPECT_EQ(graph::suggest("Spaceship", names), "");
    EXPECT_EQ(graph::suggest("Wood", names), "");
    // By a word that both have: of capitals, of '_', or its beginning.
    names.insert(names.end(), {"ReadMesh", "WriteMesh", "left_leg", "FBXFile"});
    EXPECT_EQ(graph::suggest("SkinCluster", names), "available: 'Skin' and 18 more");
    EXPECT_EQ(graph::suggest("PointDeform", names), "available: 'Points' and 18 more");
    EXPECT_EQ(graph::suggest("write_textures", names), "available: 'WriteMesh' and 18 more");
    EXPECT_EQ(graph::suggest("lower_left_arm", names), "available: 'left_leg' and 18 more");
    EXPECT_EQ(graph::suggest("FBX", names), "available: 'FBXFile' and 18 more");
    // A list that is shown whole stays in its order.
    names.resize(9);
    EXPECT_EQ(graph::suggest("Plain", names).find("available: 'Ball', 'Carry'"), 0u);
}

// A letter and a swap are two mistakes: what is one mistake off is nearer.
TEST(Mistakes, OfSwappedLettersCountOnTopOfOthers)
{
    const std::array<std::string_view, 2> known{"abcdefig", "zbcdefgx"};
    EXPECT_EQ(graph::nearest("abcdefgi", known), "abcdefig");
    EXPECT_EQ(graph::nearest("zbcdefgi", known), "zbcdefgx");
}

TEST(Mistakes, OfPathsNameTheWayOut)
{
    const auto bake = [](const std::string& path) {
        return nodes("\"b\": { \"type\": \"Bake@1\", \"params\": { \"report\": ^\"" + path +
                     "\" } }");
    };
    const std::string says = "error: node 'b', parameter 'report': expected ";
    expect_each({
        {bake("/tmp/report.txt"),
         says + "a path inside the output folder, found \"/tmp/report.txt\"; use one without '..' "
                "and without '/' at its beginning, or pass --allow-outside"},
        {bake("loaf.$F4.txt"), says +
                                   "#### for the number of the frame, found \"loaf.$F4.txt\"; use "
                                   "loaf.####.txt"},
        {bake("loaf_%04d.txt"), says + "#### for the number of the frame, found "
                                       "\"loaf_%04d.txt\"; use loaf_####.txt"},
    });
    EXPECT_TRUE(load(unmark(bake("100%done.####.txt")).first).ok());
}

}  // namespace
