#pragma once

// The reference of node types, written from their descriptions: a page, or text for a terminal.

#include "graph/types/param.hpp"

#include <string>
#include <string_view>

namespace graph {

class Registry;
struct NodeType;

// All types as one Markdown page.
std::string reference_page(const Registry& registry);

// One type for a terminal of `width` columns.
std::string reference_text(const NodeType& type, int width = 100);

// A line a type: its name and summary. With a word only types that speak of it: in name, synonyms
// or summary, or else of which a port or parameter does, which follows below; empty when none does.
std::string reference_list(const Registry& registry, std::string_view word = {});

// A value as a document would say it: 0.5, "text", [0, 0, 1].
std::string value_text(const ParamValue& value);

}  // namespace graph
