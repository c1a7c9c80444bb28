#pragma once

#include "graph/node_type.hpp"

namespace nodes {

// Every node type there is, one a file in this folder; CMakeLists.txt writes the list.
const graph::Registry& registry();

}  // namespace nodes
