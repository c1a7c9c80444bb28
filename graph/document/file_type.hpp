#pragma once

// The names of node types that are documents.

#include "graph/document/json.hpp"

#include <optional>
#include <string>

namespace graph {

// A node type's name that is a file: "assets/jelly.json@2" is that path and "2".
struct FileType {
    std::string path;
    std::optional<std::string> version;
};

// Nothing when `type` names no document.
std::optional<FileType> file_type(const Json* type);

}  // namespace graph
