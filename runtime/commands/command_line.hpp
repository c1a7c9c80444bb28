#pragma once

// The command line, as functions of arguments and streams, so that tests need no process.

#include "graph/types/registry.hpp"
#include "runtime/commands/console.hpp"

#include <string>
#include <vector>

namespace runtime {

// `args` without the program's name.
int run_command_line(const std::vector<std::string>& args, const graph::Registry& registry,
                     Console& console);

}  // namespace runtime
