#pragma once

// Which program this is. Every key contains it, so that another build never takes over the results
// of this one.

#include "runtime/cache/key.hpp"

#include <filesystem>
#include <span>

namespace runtime {

// Names the program that runs, libraries included, by the build ids that the linker gave them: a
// result is only ever taken from a cache when this very code would make it again. `later` are
// libraries ("libOSMesa.so.8") that it loads only when it comes to need them, and `programs` those
// that it runs to read and write files.
Key program_identity(std::span<const char* const> later = {},
                     std::span<const std::filesystem::path> programs = {});

}  // namespace runtime
