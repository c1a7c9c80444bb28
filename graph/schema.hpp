#pragma once

#include "graph/node_type.hpp"

#include <string>

namespace graph {

// A JSON Schema (draft-07) of graph documents with these node types: an editor that reads it
// completes names, shows the descriptions and checks types, choices and ranges.
std::string schema_text(const Registry& registry);

}  // namespace graph
