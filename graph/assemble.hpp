#pragma once

// From files to one flat list of nodes: shot files laid over the documents that they extend,
// subgraph files put in place of the nodes that name them, parameters set from outside.

#include "graph/document.hpp"
#include "graph/json.hpp"
#include "graph/read_params.hpp"

#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace graph {

// A node as the documents put it.
struct Declaration {
    std::string name;  // "outer/inner" when it came from a subgraph
    Place place;
    Json body;
};

// What a subgraph's outputs stand for: links inside of it.
struct Stand {
    std::vector<std::pair<std::string, Json>> outputs;
};

struct Assembly {
    FrameRange range;
    std::vector<Declaration> declarations;
    std::unordered_map<std::string, Stand> subgraphs;  // by the node's name
    std::unordered_set<std::string> missed;  // "outer/inner.input" that outer was told to link
    std::optional<Json> expect;
    std::vector<std::filesystem::path> documents;  // every file read, the main one first
    std::vector<std::unique_ptr<Origin>> origins;
};

// Reports into `problems` and returns what made sense all the same.
Assembly assemble(std::string text, const std::filesystem::path& file, const PathRules& paths,
                  const LoadOptions& options, Problems& problems);

// ---- what the loader's parts share --------------------------------------------------------------

Problem problem_at(Place place, std::string message = {});
// "expected ..., found ...".
Problem wrong(const Json& found, std::string expected);
// Reports the members of an object that are none of `known`.
void refuse_unknown(const Json& json, std::span<const std::string_view> known,
                    const std::string& what, const std::string& node, Problems& problems);
void want_text(const Json* json, const std::string& node, Problems& problems);
// A number or constant expression; null after a report.
std::optional<double> read_number(const Json& json, const std::string& expected,
                                  Problems& problems);
std::optional<int> read_frame(const Json& json, Problems& problems);

// The text of a document; a problem instead when it cannot be had.
std::optional<std::string> read_document(const std::filesystem::path& file, std::size_t max_bytes,
                                         Problem& problem);

}  // namespace graph
