#pragma once

// One number for all vertices in one place, whatever a file or a merge made of them.

#include "geometry/base/vec.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

namespace geometry {

// Of each vertex the first one in its place; of one that is not finite its own number.
template <class Point> std::vector<std::uint32_t> first_in_place(std::span<const Point> positions)
{
    std::vector<std::uint32_t> out(positions.size()), order;
    std::iota(out.begin(), out.end(), 0u);
    for (const std::uint32_t v : out) {
        if (positions[v].allFinite()) order.push_back(v);
    }
    const auto key = [&](std::uint32_t v) {
        const Point& p = positions[v];
        return std::tuple(p.x(), p.y(), p.z(), v);
    };
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
    for (std::size_t i = 1; i < order.size(); ++i) {
        const bool same = positions[order[i]] == positions[order[i - 1]];
        if (same) out[order[i]] = out[order[i - 1]];
    }
    return out;
}

}  // namespace geometry
