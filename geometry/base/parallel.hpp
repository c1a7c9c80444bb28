#pragma once

// Loops over both cores whose results do not depend on how many cores there are. Each piece looks
// first whether it is to stop (stop.hpp), and so does each loop, however short.

#include "geometry/base/stop.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace geometry {

// Calls body(begin, end) on pieces of 0..n, half of `grain` or more each, in any order and threads.
template <class Body> void parallel_for(std::size_t n, std::size_t grain, const Body& body)
{
    stop_if_asked();
    if (n <= grain) {
        if (n > 0) body(std::size_t{0}, n);
        return;
    }
    const std::stop_token* const stop = StopScope::current();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain), [&](const auto& r) {
        const StopScope scope(stop);
        stop_if_asked();
        body(r.begin(), r.end());
    });
}

// The sum of partial(begin, end) over fixed pieces of `grain`, added in order: the same bits for
// any number of threads.
template <class T, class Partial>
T ordered_sum(std::size_t n, std::size_t grain, T zero, const Partial& partial)
{
    stop_if_asked();
    const std::size_t pieces = (n + grain - 1) / grain;
    if (pieces <= 1) return n > 0 ? zero + partial(std::size_t{0}, n) : zero;
    std::vector<T> sums(pieces, zero);
    const std::stop_token* const stop = StopScope::current();
    tbb::parallel_for(std::size_t{0}, pieces, [&](std::size_t i) {
        const StopScope scope(stop);
        stop_if_asked();
        sums[i] = partial(i * grain, std::min(n, (i + 1) * grain));
    });
    T total = zero;
    for (const T& s : sums) total = total + s;
    return total;
}

}  // namespace geometry
