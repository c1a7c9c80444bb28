#pragma once

// Vectors whose numbers are set by whoever fills them: making one touches no memory, so that a
// large one costs nothing until threads fill it, each its share.

#include "physics/math/aligned_memory.hpp"

#include <new>
#include <utility>
#include <vector>

namespace physics {

template <class T> struct UnsetAllocator : AlignedAllocator<T> {
    template <class U> struct rebind {
        using other = UnsetAllocator<U>;
    };

    UnsetAllocator() = default;
    template <class U> UnsetAllocator(const UnsetAllocator<U>&) {}
    template <class U> void construct(U* at) { ::new (static_cast<void*>(at)) U; }
    template <class U, class... From> void construct(U* at, From&&... from)
    {
        ::new (static_cast<void*>(at)) U(std::forward<From>(from)...);
    }
};
template <class T> using Unset = std::vector<T, UnsetAllocator<T>>;

}  // namespace physics
