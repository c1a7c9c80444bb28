#pragma once

#include "runtime/cook_command.hpp"

namespace runtime {

// Cooks again, from nothing, what a manifest tells of, and compares every output; says too what is
// not any more as it was. exit_failed when an output differs, or the file of one was touched.
int verify(const std::filesystem::path& manifest, const CookRequest& request,
           const graph::Registry& registry, Console& console);

}  // namespace runtime
