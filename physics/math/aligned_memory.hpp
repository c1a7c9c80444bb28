#pragma once

// Arrays that begin on a cache line, for SIMD loops. Their numbers are set by whoever fills them:
// making one or growing one without a value touches no memory, so that a large array costs nothing
// until threads fill it, each its share.

#include "geometry/base/aligned_memory.hpp"

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace physics {

template <class T> struct AlignedAllocator {
    using value_type = T;

    AlignedAllocator() = default;
    template <class U> AlignedAllocator(const AlignedAllocator<U>&) {}
    template <class U> void construct(U* at) { ::new (static_cast<void*>(at)) U; }
    template <class U, class... From> void construct(U* at, From&&... from)
    {
        ::new (static_cast<void*>(at)) U(std::forward<From>(from)...);
    }
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
