#pragma once

// Files that say what they are, so that a foreign, truncated or damaged one is told:
//
//   aspic-scene 1\n    kind and version, a line of text
//   8 bytes            length of the content
//   16 bytes           its XXH3-128 hash
//   the content
//
// Numbers are little-endian.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace geometry {

std::string seal(std::string_view kind, int version, std::string_view content);

// The content of what seal() made of the same kind and version; a part of `bytes`. Throws
// std::runtime_error saying what was expected and what was found.
std::string_view unseal(std::string_view kind, int version, std::string_view bytes);

// The hash of some content, and as 32 hexadecimal digits: a name for it.
using ContentHash = std::array<std::uint64_t, 2>;
ContentHash hash_of(std::string_view content);
std::string name_of(const ContentHash& hash);

}  // namespace geometry
