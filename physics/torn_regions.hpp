#pragma once

#include "physics/lattice.hpp"
#include "physics/torn_lattice.hpp"

#include <functional>
#include <list>
#include <mutex>

namespace physics {

// The regions of a lattice of which links are broken, for the last few sets of links that were
// asked for; when more break, only what lies around those is looked at again. A function of the
// body and the links alone, so what is kept changes how long a step takes, never what it gives.
class TornRegions {
public:
    using Found = std::shared_ptr<const MatchedRegions>;

    TornRegions(Lattice lattice, std::vector<std::array<double, 3>> matter, double h,
                bool with_spread)
        : lattice_(std::move(lattice)), matter_(std::move(matter)), h_(h), with_spread_(with_spread)
    {}

    // `whole` are the body's own, `broken` as in State; links that never were are none that break.
    Found find(const MatchedRegions& whole, const std::vector<std::uint32_t>& broken);

    const Lattice& lattice() const { return lattice_; }
    std::size_t bytes() const;

private:
    struct Kept {
        std::vector<std::uint32_t> broken;
        Found found;
        std::unique_ptr<TornLattice> lattice;  // until another goes on from it
    };

    // `before` are those of some of the links.
    MatchedRegions match(const MatchedRegions& whole, const MatchedRegions& before,
                         const TornLattice& torn) const;

    static constexpr std::size_t most = 2;
    Lattice lattice_;
    std::vector<std::array<double, 3>> matter_;  // as match_regions() wants it
    double h_;
    bool with_spread_;
    std::mutex mutex_;
    std::list<Kept> kept_;  // newest first
};

// Mean square and mean fourth power of the places -w .. w.
inline double mean_square_place(double w)
{
    return w * (w + 1) / 3;
}
inline double mean_fourth_place(double w)
{
    return mean_square_place(w) * (3 * w * w + 3 * w - 1) / 5;
}

// The share of a region's twist that a plane resists, see lattice.hpp.
inline double twist_share(double w)
{
    const double m2 = mean_square_place(w);
    return (mean_fourth_place(w) - m2 * m2) / (2 * m2 * m2);
}

// The twist of the regions of a plane whose particles weigh `mass`, into `twist`; of the slots that
// `which` says. `place` of a particle is in lattice steps along regions.axes, from any particle on.
template <class T>
void find_twist(const LatticeRegions& regions, std::span<const float> mass,
                const std::function<std::array<double, 2>(std::size_t)>& place,
                const std::function<bool(std::size_t)>& which, std::vector<RegionTwist<T>>& twist);

// s^2, and b^2 of a plane, of a region that holds this much `matter`.
struct RegionRates {
    float rate_sq, bend_sq;
};
RegionRates rates_of(const std::array<double, 3>& matter, int half_width, double h);

// What the regions of the slots that `which` says see of how their matter is spread: B^-1,
// with_spread, and the twist of a plane's. Others keep what they have.
void find_spread(MatchedRegions& matched, const Lattice& lattice, bool with_spread,
                 const std::function<bool(std::size_t)>& which);

// What belongs to regions. `matter` holds, for each particle, its share of E V (Pa m^3), its mass
// (kg) and mass (t / h)^2 of a plane of thickness t; `with_spread`: B^-1 too.
MatchedRegions match_regions(LatticeRegions regions, const Lattice& lattice,
                             const std::vector<std::array<double, 3>>& matter, double h,
                             bool with_spread);

}  // namespace physics
