#pragma once

// The canonical text of a document, as `aspic fmt` writes it.

#include "graph/document/problem.hpp"

#include <filesystem>
#include <optional>
#include <string>

namespace graph {

// The one canonical text of a document: members in a fixed order (nodes stay in the author's), two
// spaces, what fits in 100 columns on one line, numbers as short as they read back. Comments stay
// with what they stand before or behind. Null when it is not JSON; `problems` says why.
std::optional<std::string> format_document(std::string text, const std::filesystem::path& file,
                                           Problems& problems);

}  // namespace graph
