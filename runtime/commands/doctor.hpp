#pragma once

// `doctor`: whether this machine has what cooking needs.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_doctor_command(const CommandSet& set);

// Whether the machine has what cooking needs, a line each. exit_failed when something without which
// nothing works is missing.
int doctor(const CookRequest& request, Console& console);

}  // namespace runtime
