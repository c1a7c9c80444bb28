#include "physics/regions/charts.hpp"

#include "geometry/base/union_find.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <tuple>

namespace physics {

std::vector<Chart> make_charts(const Lattice& lattice)
{
    const auto n = std::uint32_t(lattice.count());
    geometry::Sets sets(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        for (int d = 0; d < 3; ++d) {
            const std::uint32_t j = lattice.next[i][std::size_t(d)];
            if (j == none) continue;
            if (j >= n || lattice.at[j] - lattice.at[i] != Vec3i::Unit(d)) {
                throw std::invalid_argument(fmt::format(
                    "expected particle {} to link to its neighbour along axis {}, found "
                    "particle {}",
                    i, d, j));
            }
            sets.join(i, j);
        }
    }
    const std::vector<std::uint32_t> root = sets.roots();
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) {
        const Vec3i& p = lattice.at[i];
        return std::tuple(root[i], p[2], p[1], p[0], i);
    };
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
    std::vector<Chart> charts;
    std::size_t first = 0;  // chart of the component's first copies
    std::size_t copy = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const bool fresh = k == 0 || root[order[k]] != root[order[k - 1]];
        if (fresh) first = charts.size();
        copy = !fresh && lattice.at[order[k]] == lattice.at[order[k - 1]] ? copy + 1 : 0;
        if (first + copy == charts.size()) charts.emplace_back();
        charts[first + copy].particles.push_back(order[k]);
    }
    return charts;
}

}  // namespace physics
