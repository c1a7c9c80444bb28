#pragma once

// What a document promises of numbers on wires: its member "expect" (docs/file-format.md).

#include "graph/document/loading.hpp"

namespace graph {

// From Loading::expect to the graph's expectations.
void read_expectations(Loading& loading);

}  // namespace graph
