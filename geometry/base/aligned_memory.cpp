#include "geometry/base/aligned_memory.hpp"

#ifdef ASPIC_SANITIZED
#include <new>
#else
#include <sys/resource.h>
#include <unistd.h>

#include <tbb/cache_aligned_allocator.h>
#include <tbb/scalable_allocator.h>

#include <algorithm>
#endif

namespace geometry {

#ifdef ASPIC_SANITIZED
// Plain memory in place of libtbbmalloc's, which sanitizers cannot follow: so they see what lies
// beside an array and whose memory it was before.
void* take_aligned(std::size_t bytes)
{
    return ::operator new (bytes, std::align_val_t{128});
}

void give_aligned(void* memory, std::size_t) noexcept
{
    ::operator delete (memory, std::align_val_t{128});
}
#else
// Arrays of a million cubes, tens of megabytes each, are taken anew in each step. As the library
// is, it gives them back to the system, and the step waits for fresh pages half of its time. So it
// keeps them, until the process has three quarters of the memory that it may have.
static bool keep_large_arrays()
{
    const auto machine = static_cast<std::size_t>(::sysconf(_SC_PHYS_PAGES)) *
                         static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    rlimit limit{};
    const std::size_t most = ::getrlimit(RLIMIT_DATA, &limit) == 0
                                 ? std::min<std::size_t>(machine, limit.rlim_cur)
                                 : machine;
    ::scalable_allocation_mode(TBBMALLOC_SET_HUGE_SIZE_THRESHOLD, 1 << 20);
    ::scalable_allocation_mode(TBBMALLOC_SET_SOFT_HEAP_LIMIT, static_cast<intptr_t>(most / 4 * 3));
    return true;
}

void* take_aligned(std::size_t bytes)
{
    [[maybe_unused]] static const bool kept = keep_large_arrays();
    return tbb::cache_aligned_allocator<char>().allocate(bytes);
}

void give_aligned(void* memory, std::size_t bytes) noexcept
{
    tbb::cache_aligned_allocator<char>().deallocate(static_cast<char*>(memory), bytes);
}
#endif

}  // namespace geometry
