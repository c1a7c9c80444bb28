#pragma once

// `verify`: repeats the cook that a manifest describes, without caches and in a temporary folder,
// and compares what comes out with what the manifest says.

#include "runtime/commands/command_options.hpp"

namespace runtime {

void add_verify_command(const CommandSet& set);

// Cooks again, from nothing, what a manifest tells of, and compares every output; says too what is
// not any more as it was. exit_failed when an output differs, or the file of one was touched.
int verify(const std::filesystem::path& manifest, const CookRequest& request,
           const graph::Registry& registry, Console& console);

}  // namespace runtime
