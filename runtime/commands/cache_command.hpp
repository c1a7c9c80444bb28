#pragma once

// `cache`: how much is stored, whether it is sound, and making it smaller.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_cache_command(const CommandSet& set);

}  // namespace runtime
