#pragma once

// The regions of a lattice by their definition.

#include "physics/regions/links.hpp"

#include <set>

namespace fixtures {

// What links reach from each particle inside the box of half width w around it, by searching
// particle by particle; in ascending order.
inline std::vector<std::vector<std::uint32_t>> regions_by_search(const physics::Lattice& lattice,
                                                                 int w)
{
    std::vector<std::vector<std::uint32_t>> neighbours(lattice.count()), regions;
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (const auto j : lattice.next[i]) {
            if (j == physics::none) continue;
            neighbours[i].push_back(j);
            neighbours[j].push_back(i);
        }
    }
    for (std::uint32_t r = 0; r < lattice.count(); ++r) {
        std::set<std::uint32_t> seen{r};
        std::vector<std::uint32_t> queue{r};
        while (!queue.empty()) {
            const auto i = queue.back();
            queue.pop_back();
            for (const auto j : neighbours[i]) {
                if ((lattice.at[j] - lattice.at[r]).cwiseAbs().maxCoeff() > w) continue;
                if (seen.insert(j).second) queue.push_back(j);
            }
        }
        regions.emplace_back(seen.begin(), seen.end());
    }
    return regions;
}

}  // namespace fixtures
