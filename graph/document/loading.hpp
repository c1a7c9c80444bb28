#pragma once

// The state of loading one document: plain data that load_text() in document.cpp hands from step to
// step. Each step is a file of free functions:
//
//      file  --read_documents, shots-->  one tree, laid over what it extends
//      tree  --declarations---------->   frames, variables, nodes by name
//            --overrides------------->   parameters set from outside
//            --subgraphs, ports------>   one flat list of declarations
//            --make_nodes------------>   nodes with their types and parameters
//            --links----------------->   what each node takes from which
//            --check_settings-------->   what every cook would fail at
//            --expectations---------->   what the numbers must hold
//            --sort_nodes------------>   the Graph
//
// A step reports into `problems` and goes on with what made sense all the same, so that all
// mistakes of a document are found in one go.

#include "graph/document/expression.hpp"
#include "graph/document/graph.hpp"
#include "graph/document/json.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/path_rules.hpp"
#include "graph/document/problem.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace graph {

class Registry;

// A document with those that it extends: one set of variables and names.
struct Document {
    std::vector<std::filesystem::path> chain;  // files that led here, against circles
    std::vector<Origin*> origins;              // of its files
    std::string prefix;                        // "outer/" for a subgraph's nodes
};

// A node as the documents put it.
struct Declaration {
    std::string name;  // "outer/inner" when it came from a subgraph
    Place place;
    Json body;
};

// What a subgraph's outputs stand for: links inside of it, by the output's name.
using SubgraphOutputs = std::vector<std::pair<std::string, Json>>;

struct Loading {
    const Registry& registry;
    const LoadOptions& options;
    PathRules paths;
    Problems problems = {};

    // What was read.
    std::shared_ptr<const Grammar> plain = std::make_shared<const Grammar>();  // has no variables
    std::vector<std::unique_ptr<Origin>> origins = {};
    std::map<std::filesystem::path, std::shared_ptr<const Source>> sources = {};  // canonical paths

    // What the documents say.
    std::vector<Declaration> declarations = {};
    std::size_t declared = 0;  // nodes so far, those that stand for subgraphs included
    std::unordered_map<std::string, SubgraphOutputs> subgraphs = {};  // by the node's name
    std::unordered_set<std::string> reported_unlinked = {};  // "outer/inner.input": outer must link
    std::optional<Json> expect = {};

    // What becomes of it. Nodes stand in the order of the declarations until they are sorted.
    Graph graph = {};
    std::unordered_map<std::string_view, std::uint32_t> index = {};  // of nodes by name
    // Old names of outputs and the new ones, of nodes that were upgraded.
    std::unordered_map<std::uint32_t, std::vector<std::pair<std::string, std::string>>> renamed =
        {};

    // For suggestions, made when first needed.
    std::vector<std::string_view> names = {};                      // of nodes and subgraphs
    std::size_t compared = 0;                                      // names, for all suggestions
    std::map<std::string, std::vector<std::string>> outputs = {};  // by wire type: "node.output"

    Variables variables = {};  // of the main document
};

}  // namespace graph
