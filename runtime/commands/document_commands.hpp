#pragma once

// Commands that read documents or node descriptions and cook nothing: `validate`, `nodes`,
// `schema`, `new`, `fmt`, `diff` and `graph`.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_document_commands(const CommandSet& set);

}  // namespace runtime
