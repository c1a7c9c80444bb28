#pragma once

// A JSON Schema of graph documents, for editors.

#include <string>

namespace graph {

class Registry;

// A JSON Schema (draft-07) of graph documents with these node types: an editor that reads it
// completes names, shows the descriptions and checks types, choices and ranges.
std::string schema_text(const Registry& registry);

}  // namespace graph
