#pragma once

// Arrays that begin on a cache line, for SIMD loops.

#include "geometry/base/aligned_memory.hpp"

#include <cstddef>
#include <vector>

namespace physics {

template <class T> struct AlignedAllocator {
    using value_type = T;

    AlignedAllocator() = default;
    template <class U> AlignedAllocator(const AlignedAllocator<U>&) {}
    T* allocate(std::size_t count)
    {
        return static_cast<T*>(geometry::take_aligned(count * sizeof(T)));
    }
    void deallocate(T* array, std::size_t count) noexcept
    {
        geometry::give_aligned(array, count * sizeof(T));
    }
    bool operator==(const AlignedAllocator&) const = default;
};

template <class T> using Aligned = std::vector<T, AlignedAllocator<T>>;

}  // namespace physics
