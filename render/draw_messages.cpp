#include "render/draw_messages.hpp"

#include <sys/mman.h>

#include <new>

namespace render {

SharedMemory::~SharedMemory()
{
    if (at_) ::munmap(at_, size_);
}

std::byte* SharedMemory::map(std::size_t bytes)
{
    if (bytes <= size_) return at_;
    if (at_) ::munmap(at_, size_);
    at_ = nullptr;
    size_ = 0;
    void* const at = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
    if (at == MAP_FAILED) throw std::bad_alloc();
    at_ = static_cast<std::byte*>(at);
    size_ = bytes;
    return at_;
}

}  // namespace render
