#pragma once

// Memory for long arrays that are read at places far apart. It lies on large pages where the system
// has them, so that such reads do not wait for the page tables.

#include <cstddef>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace physics {

template <class T> struct LargePages {
    using value_type = T;

    LargePages() = default;
    template <class U> LargePages(const LargePages<U>&) {}

    T* allocate(std::size_t n)
    {
        void* const room = ::operator new(n * sizeof(T), edge(n));
#ifdef __linux__
        if (edge(n) == large) madvise(room, n * sizeof(T), MADV_HUGEPAGE);  // only a hint
#endif
        return static_cast<T*>(room);
    }
    void deallocate(T* room, std::size_t n)
    {
        ::operator delete(room, edge(n));
    }

    bool operator==(const LargePages&) const
    {
        return true;
    }

private:
    static constexpr std::align_val_t large{std::size_t{2} << 20};

    static std::align_val_t edge(std::size_t n)
    {
        return n * sizeof(T) < 2 * std::size_t(large) ? std::align_val_t(alignof(T)) : large;
    }
};

}  // namespace physics
