#include "geometry/base/aligned_memory.hpp"

#ifdef ASPIC_SANITIZED
#include <new>
#else
#include <tbb/cache_aligned_allocator.h>
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
void* take_aligned(std::size_t bytes)
{
    return tbb::cache_aligned_allocator<char>().allocate(bytes);
}

void give_aligned(void* memory, std::size_t bytes) noexcept
{
    tbb::cache_aligned_allocator<char>().deallocate(static_cast<char*>(memory), bytes);
}
#endif

}  // namespace geometry
