#pragma once

// Where encoded bytes go. encode.hpp writes values into an Encoder; the caches decide what becomes
// of the bytes: they gather in a text, run through a hash, or land in a file.

#include "graph/types/content_name.hpp"

#include <functional>
#include <memory>
#include <string>

namespace graph {

struct Encoder {
    std::string bytes;
    // Takes the bytes bit by bit, where nobody needs them all at once; else they gather in `bytes`.
    std::function<void(const void* data, std::size_t size)> sink = {};
    // Stores shared content, encoded by `encode`, and returns its name.
    std::function<ContentName(const std::shared_ptr<const void>& content, const std::string& layout,
                              void (*encode)(const void*, Encoder&))>
        share = {};

    void raw(const void* data, std::size_t size)
    {
        if (sink && size > 4096) {
            drain();
            sink(data, size);
            drained_ += size;
            return;
        }
        bytes.append(static_cast<const char*>(data), size);
        if (sink && bytes.size() > 4096) drain();
    }
    // Zeros up to a multiple of 8 bytes, so that what follows is aligned in memory when read.
    void pad() { raw("\0\0\0\0\0\0\0", (8 - (drained_ + bytes.size()) % 8) % 8); }
    // Hands the sink what it has not seen yet.
    void drain()
    {
        sink(bytes.data(), bytes.size());
        drained_ += bytes.size();
        bytes.clear();
    }

private:
    std::size_t drained_ = 0;
};

}  // namespace graph
