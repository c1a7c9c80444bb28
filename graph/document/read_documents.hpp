#pragma once

// From files to trees: a document's text, its head, and the documents that it extends.

#include "graph/document/loading.hpp"

namespace graph {

// The text of a document; null after reporting into `problem` why there is none.
std::optional<std::string> read_file(const std::filesystem::path& file, std::size_t max_bytes,
                                     Problem& problem);

// A new origin, for values of this document that come from `source`.
Origin& new_origin(Loading& loading, Document& document, std::shared_ptr<const Source> source);

// The document's tree, laid over what it extends; null after a report.
std::optional<Json> read_document(Loading& loading, Document& document,
                                  std::shared_ptr<const Source> source);

// The document of this path, which `json` names; null after a report. It becomes part of the chain.
std::shared_ptr<const Source> find_document(Loading& loading, const Json& json,
                                            const std::string& text,
                                            std::vector<std::filesystem::path>& chain,
                                            const std::string& node = {});

}  // namespace graph
