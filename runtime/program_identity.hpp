#pragma once

#include "runtime/key.hpp"

namespace runtime {

// Names the program that runs, libraries included, by the build ids that the linker gave them: a
// result is only ever taken from a cache when this very code would make it again.
Key program_identity();

}  // namespace runtime
