#pragma once

// Parameters set from outside the document, `--set cubes.size=0.02`: they go before everything that
// the document says.

#include "graph/document/loading.hpp"

namespace graph {

enum class OverridesOf { document, subgraphs };

// Applies those of LoadOptions::sets that name nodes of the document itself, or those that name
// nodes inside of subgraphs (with a slash in the name), which wait until the subgraphs took their
// places.
void apply_overrides(Loading& loading, std::vector<Declaration>& declarations, Document& document,
                     OverridesOf which);

// Sets a parameter of a node's body: "size", "bricks.damping", "boxes.2.centre". What is wrong, if
// anything, else null.
std::optional<Problem> set_param(Json& body, std::string_view path, Json value);

}  // namespace graph
