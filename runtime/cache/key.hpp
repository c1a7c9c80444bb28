#pragma once

// Names of results. A key is the 128-bit XXH3 hash of everything that a result depends on, so two
// results with one key are equal, on any machine and at any time.

#include "graph/types/param.hpp"

#include <xxhash.h>

#include <array>
#include <compare>
#include <cstring>
#include <string>
#include <string_view>

namespace runtime {

struct Key {
    std::uint64_t low = 0, high = 0;
    auto operator<=>(const Key&) const = default;
    explicit operator bool() const { return (low | high) != 0; }  // the zero key names nothing
};

// A key is uniform already: any 64 bits of it are a hash.
struct KeyHash {
    std::size_t operator()(const Key& key) const { return key.low; }
};

// 32 hexadecimal digits, and back; from_hex gives a zero key for anything else.
std::string to_hex(const Key& key);
Key from_hex(std::string_view text);

Key hash_bytes(const void* data, std::size_t size);

// Collects what a key depends on. Everything of variable length goes in with its length, so that
// ("ab", "c") and ("a", "bc") differ. All of it is whole words: the hash reads words, and a
// processor that reads a word which was written in two pieces waits until both reach the cache.
class KeyBuilder {
public:
    template <class T>
    requires std::is_arithmetic_v<T> KeyBuilder& add(T number)
    {
        static_assert(sizeof number <= sizeof(std::uint64_t));
        std::uint64_t word = 0;
        std::memcpy(&word, &number, sizeof number);
        append(&word, sizeof word);
        return *this;
    }
    KeyBuilder& add(const Key& key)
    {
        append(&key, sizeof key);
        return *this;
    }
    KeyBuilder& add(std::string_view text)
    {
        constexpr std::size_t whole = sizeof(std::uint64_t);
        const std::uint64_t nothing = 0;
        add(text.size());
        append(text.data(), text.size());
        append(&nothing, (whole - text.size() % whole) % whole);
        return *this;
    }
    KeyBuilder& add(const graph::ParamValue& value)
    {
        add(static_cast<std::uint8_t>(value.is.index()));
        const double* const number = std::get_if<double>(&value.is);
        return number ? add(*number) : add_content(value);
    }

    void clear() { size_ = 0, long_.clear(); }
    Key key() const
    {
        return long_.empty() ? hash_bytes(short_.data(), size_)
                             : hash_bytes(long_.data(), long_.size());
    }

private:
    KeyBuilder& add_content(const graph::ParamValue& value);  // its type stands there already
    // A compiler that does not see what a few bytes cost to copy calls a function for them.
    [[gnu::always_inline]] void append(const void* data, std::size_t size)
    {
        if (size_ + size > short_.size()) return append_long(data, size);
        std::memcpy(short_.data() + size_, data, size);
        size_ += size;
    }
    void append_long(const void* data, std::size_t size);

    std::array<char, 248> short_;  // most keys fit: no memory to ask for
    std::size_t size_ = 0;         // more than that, once it does not fit
    std::string long_;             // then all of it
};

}  // namespace runtime
