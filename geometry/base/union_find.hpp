#pragma once

// Things that are joined into sets, two at a time: union-find with path halving and linking by
// index (Tarjan, van Leeuwen. Worst-case analysis of set union algorithms. JACM 31(2), 1984).

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace geometry {

class UnionFind {
public:
    explicit UnionFind(std::size_t n) : parent_(n)
    {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }

    // The first of its set, by number.
    std::uint32_t root(std::uint32_t i)
    {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }

    void join(std::uint32_t a, std::uint32_t b)
    {
        a = root(a), b = root(b);
        if (a != b) parent_[std::max(a, b)] = std::min(a, b);
    }

    std::vector<std::uint32_t> roots()
    {
        for (std::uint32_t i = 0; i < parent_.size(); ++i) parent_[i] = root(i);
        return parent_;
    }

private:
    std::vector<std::uint32_t> parent_;
};
using Sets = UnionFind;  // its name until now

}  // namespace geometry
