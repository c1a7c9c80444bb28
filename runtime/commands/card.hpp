#pragma once

// The accuracy card: how far each body that Voxelize makes is from its mesh.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_card_command(const CommandSet& set);

// Cooks the bodies at a graph's first frame, and nothing else.
int run_card(const CookRequest& request, const graph::Registry& registry, Console& console);

}  // namespace runtime
