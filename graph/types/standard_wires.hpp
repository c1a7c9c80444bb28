#pragma once

// Wire types that the runtime itself understands: a number can be expected and studied, a written
// file is told to the person who cooks.

#include "graph/types/value.hpp"

#include <string>
#include <vector>

namespace graph {

// A file that a sink wrote.
struct WrittenFile {
    std::string path;                      // where it is, as the process can open it
    std::vector<std::string> beside = {};  // other files that it is of no use without
    bool shared = false;                   // other frames write to it, too
};

template <> inline constexpr const char* wire_name<double> = "number";
template <> inline constexpr const char* wire_name<WrittenFile> = "file";

extern template const WireType& wire_type<double>();
extern template const WireType& wire_type<WrittenFile>();

}  // namespace graph
