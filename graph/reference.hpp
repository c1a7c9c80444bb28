#pragma once

// The reference of node types, written from their descriptions.

#include "graph/node_type.hpp"

#include <string>

namespace graph {

// All types as one Markdown page.
std::string reference_page(const Registry& registry);

// One type for a terminal of `width` columns.
std::string reference_text(const NodeType& type, int width = 100);

// A line a type: its name and summary.
std::string reference_list(const Registry& registry);

// A value as a document would say it: 0.5, "text", [0, 0, 1].
std::string value_text(const ParamValue& value);

}  // namespace graph
