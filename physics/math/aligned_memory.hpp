#pragma once

// Arrays that begin on a cache line, for SIMD loops.

#ifdef ASPIC_SANITIZED
#include <new>
#else
#include <tbb/cache_aligned_allocator.h>
#endif

#include <cstddef>
#include <vector>

namespace physics {

#ifdef ASPIC_SANITIZED
// Plain memory in place of libtbbmalloc's, which sanitizers cannot follow: so they see what lies
// beside an array and whose memory it was before.
template <class T> struct AlignedAllocator {
    using value_type = T;
    static constexpr std::align_val_t alignment{128};

    AlignedAllocator() = default;
    template <class U> AlignedAllocator(const AlignedAllocator<U>&) {}
    T* allocate(std::size_t count)
    {
        return static_cast<T*>(::operator new(count * sizeof(T), alignment));
    }
    void deallocate(T* array, std::size_t) { ::operator delete(array, alignment); }
    bool operator==(const AlignedAllocator&) const = default;
};
#else
template <class T> using AlignedAllocator = tbb::cache_aligned_allocator<T>;
#endif

template <class T> using Aligned = std::vector<T, AlignedAllocator<T>>;

}  // namespace physics
