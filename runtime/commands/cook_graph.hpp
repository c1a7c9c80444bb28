#pragma once

// Cooks one graph as a request says: what `cook`, `check`, `profile` and `verify` share.

#include "runtime/commands/cook_request.hpp"
#include "runtime/commands/front_end.hpp"
#include "runtime/commands/manifest.hpp"

namespace runtime {

// What went in and came out is left in `manifest`, and beside the files that were written. Returns
// the exit code.
int cook_graph(const graph::Graph& graph, const CookRequest& request, Caches& caches,
               FrontEnd& front_end, Console& console, Manifest& manifest);

}  // namespace runtime
