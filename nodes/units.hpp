#pragma once

// Units of the numbers that nodes give, for tables.

#include "graph/document/graph.hpp"

#include <string>

namespace nodes {

// Of a Measure's quantity. Empty: it has none, or is not known.
std::string unit_of(const graph::Node& node);
std::string unit_of_linked(const graph::LinkedNode& node);

}  // namespace nodes
