#pragma once

// Shots: a document laid over the one that it extends. docs/file-format.md, "Shots", has the rules.

#include "graph/document/json.hpp"
#include "graph/document/problem.hpp"

namespace graph {

// Changes the document `base` into what `over`, which extends it, makes of it.
void lay_shot_over(Json& base, Json over, Problems& problems);

}  // namespace graph
