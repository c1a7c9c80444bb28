#pragma once

// `info`: what a mesh file holds, before anything is made of it.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_info_command(const CommandSet& set);

}  // namespace runtime
