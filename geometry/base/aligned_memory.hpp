#pragma once

// Memory that begins on a cache line, for the arrays of SIMD loops.

#include <cstddef>

namespace geometry {

// Throws std::bad_alloc when there is none.
void* take_aligned(std::size_t bytes);
void give_aligned(void* memory, std::size_t bytes) noexcept;

}  // namespace geometry
