#pragma once

// What commands share: outputs by name, a document with other settings, lines of CSV.

#include "graph/document/document.hpp"
#include "runtime/commands/vary.hpp"

namespace runtime {

// The output that "node.port", or "node" of one output, names. Throws std::invalid_argument.
graph::Link find_wire(const graph::Graph& graph, const std::string& name);

bool is_picture(const graph::OutputPort& port);

// The first output that is a picture of a frame and not of many, as "node.port"; empty when there
// is none.
std::string first_picture(const graph::Graph& graph);

// What graph::load_file gives. Throws std::runtime_error, naming the document, when memory runs
// out.
graph::Loaded load_document(const std::filesystem::path& file, const graph::Registry& registry,
                            const graph::LoadOptions& options);

// The document with `settings` on top of those in `options`. Throws std::invalid_argument with all
// that is wrong.
graph::Loaded load_with(const std::filesystem::path& file, const graph::Registry& registry,
                        graph::LoadOptions options, const Settings& settings);

// What loading warned of, as warnings of nodes are told: "node 'x', parameter 'size': ...".
std::vector<std::string> warnings_of(const graph::Loaded& loaded);

// In quotes, those inside doubled, on one line.
std::string csv_quoted(const std::string& text);

}  // namespace runtime
