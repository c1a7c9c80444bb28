#pragma once

// The list of all node types, which the loader, the command line, the reference page and the tests
// read. Each type is one file in this folder with a function add_to(); CMakeLists.txt finds the
// files and writes the list.

#include "graph/types/registry.hpp"

namespace nodes {

// All node types of the program.
const graph::Registry& registry();

}  // namespace nodes
