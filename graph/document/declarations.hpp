#pragma once

// What a document declares: its frames, its variables and its nodes, by name.

#include "graph/document/loading.hpp"

namespace graph {

// The member "frames"; null: one frame.
FrameRange read_frames(Loading& loading, const Json* json);

// Gives the document's origins the member "variables" as a grammar; those in `given` replace its
// own and are taken out of there. Returns all with their values.
Variables read_variables(Loading& loading, Document& document, const Json* json,
                         std::map<std::string, double, std::less<>>& given);

// Moves the nodes out of the document's tree.
std::vector<Declaration> declare_nodes(Json& root, const std::string& prefix, Problems& problems);

}  // namespace graph
