#pragma once

// `cook`, `check` and `profile`.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_cook_commands(const CommandSet& set);

int cook(const CookRequest& request, const graph::Registry& registry, Console& console);

}  // namespace runtime
