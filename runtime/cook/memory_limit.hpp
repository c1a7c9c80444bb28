#pragma once

// A graph may ask for more memory than there is. Then the node that asked fails, as it does for
// any other reason, long before the system ends programs of its choice.

#include <cstddef>
#include <string>
#include <sys/resource.h>

namespace runtime {

// While it lives, what this process writes to (heap, stacks, private maps) is at most `bytes` in
// all. 0: nine tenths of what the machine, or the group that the process is in, has.
class MemoryLimit {
public:
    explicit MemoryLimit(std::size_t bytes);
    ~MemoryLimit();
    MemoryLimit(const MemoryLimit&) = delete;

private:
    rlimit before_{};
};

// What is said when memory could not be had, with the limit there is.
std::string out_of_memory();

}  // namespace runtime
