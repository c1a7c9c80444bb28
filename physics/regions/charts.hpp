#pragma once

// Charts: pieces of a lattice in which no two particles share a place, so that lines of the grid
// run through them without ambiguity. Most lattices are one chart; a body that lies over itself, or
// several bodies, are more.

#include "physics/regions/links.hpp"

#include <utility>

namespace physics {

// A piece of the lattice in which no two particles share a place: a connected component, or the
// second, third ... copies in one. Particles are sorted by (z, y, x).
struct Chart {
    std::vector<std::uint32_t> particles;
};

// Throws std::invalid_argument for links that are not to a neighbour.
std::vector<Chart> make_charts(const Lattice& lattice);

// Charts, and what of them tells that a region holds all of its box.
class ChartExtents {
public:
    ChartExtents(const Lattice& lattice, const std::vector<Chart>& charts, int w)
        : lattice_(lattice), w_(w), of_(lattice.count()), loose_(lattice.count(), 0)
    {
        for (std::uint32_t c = 0; c < charts.size(); ++c) {
            const Vec3i& any = lattice.at[charts[c].particles[0]];
            auto& [low, high] = extent_.emplace_back(any, any);
            for (const auto i : charts[c].particles) {
                of_[i] = c;
                low = low.cwiseMin(lattice.at[i]);
                high = high.cwiseMax(lattice.at[i]);
            }
        }
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            for (int d = 0; d < 3; ++d) {
                const std::uint32_t j = lattice.next[i][std::size_t(d)];
                if (j == none) {
                    if (lattice.at[i][d] < extent_[of_[i]].second[d]) loose_[i] = 1;
                } else if (of_[i] != of_[j]) {
                    loose_[i] = loose_[j] = 1;
                }
            }
        }
    }

    std::uint32_t of(std::uint32_t i) const { return of_[i]; }

    // Whether there might be a place beside this particle that it is not linked to. A box that is
    // full of others hangs together.
    bool is_loose(std::uint32_t i) const { return loose_[i] != 0; }

    // How many places the box around a particle has, within its chart.
    std::size_t places(std::uint32_t i) const
    {
        const auto& [low, high] = extent_[of_[i]];
        std::size_t count = 1;
        for (int d = 0; d < 3; ++d) {
            const int at = lattice_.at[i][d];
            count *= std::size_t(std::min(high[d], at + w_) - std::max(low[d], at - w_) + 1);
        }
        return count;
    }

private:
    const Lattice& lattice_;
    int w_;
    std::vector<std::uint32_t> of_;
    std::vector<std::uint8_t> loose_;
    std::vector<std::pair<Vec3i, Vec3i>> extent_;
};

}  // namespace physics
