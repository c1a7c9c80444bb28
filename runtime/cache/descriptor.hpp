#pragma once

// A file descriptor that is closed at the end.

#include <unistd.h>

namespace runtime {

struct Descriptor {
    int number = -1;  // negative: none
    explicit Descriptor(int n) : number(n) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor()
    {
        if (number >= 0) ::close(number);
    }
};

}  // namespace runtime
