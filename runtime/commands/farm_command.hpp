#pragma once

// `farm`: cooks on several machines, through a scheduler that is there already.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_farm_command(const CommandSet& set);

}  // namespace runtime
