#include "runtime/cook/memory_limit.hpp"

#include "runtime/cache/quantities.hpp"

#include <algorithm>
#include <fstream>
#include <unistd.h>

namespace runtime {

namespace {

// Of the machine, or of the container that the process runs in.
std::size_t memory_there_is()
{
    auto bytes = static_cast<std::size_t>(::sysconf(_SC_PHYS_PAGES)) *
                 static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    for (const char* file :
         {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
        std::size_t most = 0;  // "max" is no number
        if (std::ifstream(file) >> most && most > 0) bytes = std::min(bytes, most);
    }
    return bytes;
}

// What counts against the limit already.
std::size_t memory_in_use()
{
    std::size_t sizes[6] = {};  // pages: all, resident, shared, code, -, data and stacks
    std::ifstream file("/proc/self/statm");
    for (std::size_t& size : sizes) file >> size;
    return sizes[5] * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace

MemoryLimit::MemoryLimit(std::size_t bytes)
{
    if (::getrlimit(RLIMIT_DATA, &before_) != 0) return;
    const std::size_t wanted = bytes > 0 ? bytes : memory_there_is() / 10 * 9;
    // A sanitizer's own maps are larger than any memory.
    if (wanted == 0 || memory_in_use() > (std::size_t{1} << 40)) return;
    rlimit now = before_;
    now.rlim_cur = std::min<rlim_t>(wanted, before_.rlim_cur);
    ::setrlimit(RLIMIT_DATA, &now);
}

MemoryLimit::~MemoryLimit()
{
    ::setrlimit(RLIMIT_DATA, &before_);
}

std::string out_of_memory()
{
    rlimit now{};
    std::string text = "out of memory";
    if (::getrlimit(RLIMIT_DATA, &now) == 0 && now.rlim_cur != RLIM_INFINITY) {
        text += " (limit " + format_bytes(static_cast<double>(now.rlim_cur)) +
                "); lower the resolution or raise --memory-limit";
    } else {
        text += "; lower the resolution";
    }
    return text;
}

}  // namespace runtime
