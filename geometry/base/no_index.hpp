#pragma once

// The index of nothing, where an array of indices needs one.

#include <cstdint>

namespace geometry {

inline constexpr std::uint32_t no_index = ~std::uint32_t{0};

}  // namespace geometry
