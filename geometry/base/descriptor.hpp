#pragma once

// A file descriptor that is closed when it goes out of scope.

#include <unistd.h>

#include <utility>

namespace geometry {

struct Descriptor {
    int fd = -1;  // -1: none

    explicit Descriptor(int d = -1) : fd(d) {}
    Descriptor(Descriptor&& other) noexcept : fd(std::exchange(other.fd, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor() { close(); }

    void close()
    {
        if (fd >= 0) ::close(fd);
        fd = -1;
    }
};

}  // namespace geometry
