#pragma once

#include "runtime/cook_command.hpp"

namespace runtime {

// Whether the machine has what cooking needs, a line each. exit_failed when something without which
// nothing works is missing.
int doctor(const CookRequest& request, Console& console);

}  // namespace runtime
