#pragma once

#include <tbb/cache_aligned_allocator.h>

#include <vector>

namespace physics {

// Arrays that SIMD loops read.
template <class T> using Aligned = std::vector<T, tbb::cache_aligned_allocator<T>>;

}  // namespace physics
