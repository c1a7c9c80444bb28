#pragma once

// Numbers things by their first appearance: welds vertices, finds shared edges.

#include "geometry/base/no_index.hpp"
#include "geometry/base/vec.hpp"

#include <bit>
#include <stdexcept>
#include <vector>

namespace geometry {

// Numbers distinct keys 0, 1, 2 ... in order of their first appearance. A key is N words, compared
// bit by bit. Open addressing with linear probing: one table of numbers and one array of keys.
template <std::size_t N> class Numbering {
public:
    using Key = std::array<std::uint32_t, N>;

    explicit Numbering(std::size_t expected = 0)
    {
        keys_.reserve(expected);
        slots_.assign(std::bit_ceil(std::max<std::size_t>(16, 2 * expected)), no_index);
    }

    // The number of `key`; a new one when it was not seen before.
    std::uint32_t add(const Key& key)
    {
        if (2 * (keys_.size() + 1) > slots_.size()) grow();
        std::uint32_t& slot = slots_[find(key)];
        if (slot == no_index) {
            if (keys_.size() >= no_index)
                throw std::length_error("more than 2^32 - 1 different keys were numbered");
            slot = static_cast<std::uint32_t>(keys_.size());
            keys_.push_back(key);
        }
        return slot;
    }

    std::size_t size() const { return keys_.size(); }
    const std::vector<Key>& keys() const { return keys_; }

private:
    static std::uint64_t hash(const Key& key)
    {
        std::uint64_t h = 0;
        for (const std::uint32_t word : key) {
            h = (h ^ word) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29;
        }
        return h * 0xbf58476d1ce4e5b9u >> 16;
    }
    std::size_t find(const Key& key) const
    {
        const std::size_t mask = slots_.size() - 1;
        std::size_t i = hash(key) & mask;
        while (slots_[i] != no_index && keys_[slots_[i]] != key) i = (i + 1) & mask;
        return i;
    }
    void grow()
    {
        slots_.assign(2 * slots_.size(), no_index);
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            slots_[find(keys_[i])] = static_cast<std::uint32_t>(i);
        }
    }

    std::vector<Key> keys_;
    std::vector<std::uint32_t> slots_;
};

// The bits of a vector, as keys compare them: -0 counts as 0.
template <int Rows> std::array<std::uint32_t, Rows> bits(const Eigen::Matrix<float, Rows, 1>& v)
{
    std::array<std::uint32_t, Rows> words;
    for (int d = 0; d < Rows; ++d) words[std::size_t(d)] = std::bit_cast<std::uint32_t>(v[d] + 0.f);
    return words;
}

}  // namespace geometry
