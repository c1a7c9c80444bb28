#pragma once

// Encoded bytes, read from the front. Every read is checked: bytes of a damaged file throw
// std::runtime_error and never reach beyond their end.

#include "graph/types/encoder.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace graph {

class Decoder {
public:
    // Gives the content of that name, decoded by `decode` unless an equal one is at hand.
    using Shared = std::function<std::shared_ptr<const void>(
        const ContentName& name, const std::string& layout,
        std::shared_ptr<const void> (*decode)(Decoder&))>;

    explicit Decoder(std::string_view bytes) : Decoder(bytes, {}) {}
    Decoder(std::string_view bytes, Shared find)
        : shared(std::move(find)), bytes_(bytes), size_(bytes.size())
    {}

    Shared shared;

    const char* take(std::size_t size)
    {
        if (size > bytes_.size()) throw std::runtime_error("encoded value ends too early");
        const char* const data = bytes_.data();
        bytes_.remove_prefix(size);
        return data;
    }
    std::size_t left() const { return bytes_.size(); }
    void skip_padding() { take((8 - (size_ - bytes_.size()) % 8) % 8); }
    void raw(void* data, std::size_t size) { std::memcpy(data, take(size), size); }
    // A count of things of at least `each` bytes.
    std::size_t count(std::size_t each)
    {
        std::uint64_t n = 0;
        raw(&n, sizeof n);
        if (n > bytes_.size() / std::max<std::size_t>(each, 1)) {
            throw std::runtime_error("encoded value is longer than its data");
        }
        return n;
    }

private:
    std::string_view bytes_;
    std::size_t size_;  // of all of it
};

}  // namespace graph
