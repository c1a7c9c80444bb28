#pragma once

// What stored content is called: the hash of its bytes. Equal content has one name and is stored
// once.

#include <array>
#include <cstdint>

namespace graph {

// The 128-bit hash of some encoded content.
using ContentName = std::array<std::uint64_t, 2>;

}  // namespace graph
