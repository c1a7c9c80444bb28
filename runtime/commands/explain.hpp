#pragma once

// What a cook would do at a frame, and why: what it would take from the cache, what it would cook,
// and which parameter, input or file is not what it was in the last cook.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_explain_command(const CommandSet& set);

int explain(const CookRequest& request, int frame, const graph::Registry& registry,
            Console& console);

}  // namespace runtime
