#pragma once

// Regions and what shape matching knows of each: its rates of stretch and bending, how its matter
// is spread, how much of its twist a plane resists (lattice.hpp has the equations), and what its
// volume is measured by (region_volume.hpp).

#include "physics/regions/lattice_regions.hpp"

#include <functional>
#include <span>

namespace physics {

// How a region of a plane twists, in lattice steps (see lattice.hpp); a follows from sums of M psi
// = 0.
template <class T> struct RegionTwist {
    T b = 0, c = 0;
    T loose = 0;  // 1/kg, (1 - phi) / B; 0 where nothing twists
};

// What the volume of a region is measured by (region_volume.hpp), eight numbers. All 0 where it has
// none: flat, or nearly so.
template <class T> struct RegionVolume {
    std::array<T, 6> root{};  // det(B)^(1/6) B^-1/2, packed xx, xy, xz, yy, yz, zz
    T scale = 0;              // 1/kg, det(B)^(-1/3), of B in lattice steps
    T unused = 0;
};
static_assert(sizeof(RegionVolume<float>) == 8 * sizeof(float));

// Regions and what belongs to each of them, or to each particle because of them.
struct MatchedRegions {
    LatticeRegions regions;
    std::vector<float> mass;            // N, kg, M_i
    std::vector<float> held_by;         // N, 1 / |R_i|
    std::vector<float> rate_sq;         // slots, 1/s^2, s^2 from the material
    std::vector<float> bend_sq;         // slots, 1/s^2, b^2 of a plane, without the option's factor
    std::vector<float> inverse_spread;  // 6 a slot, B^-1 in lattice steps; where plastic
    std::vector<RegionTwist<float>> twist;  // slots, of a plane
    std::vector<float> poisson;             // slots, nu of a solid; empty where all are 0
    std::vector<float> volume_gain;         // likewise, g: E = k (1 + g nu), see region_volume.hpp
    std::vector<RegionVolume<float>> volume;  // likewise
    std::vector<float> stretch;  // slots, E / k of a region that resists stretch apart; or empty
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

// The volume of the regions of solids whose particles weigh `mass`, likewise.
template <class T>
void find_volume(const LatticeRegions& regions, std::span<const float> mass,
                 const std::function<geometry::Vec3(std::size_t)>& place,
                 const std::function<bool(std::size_t)>& which,
                 std::vector<RegionVolume<T>>& volume);

// B^-1 of the regions whose particles weigh `mass`, likewise; six numbers a slot.
void find_inverse_spread(const LatticeRegions& regions, std::span<const float> mass,
                         const std::function<geometry::Vec3(std::size_t)>& place,
                         const std::function<bool(std::size_t)>& which, std::vector<float>& spread);

// What a particle brings to its regions: its share of E V (Pa m^3), its mass (kg), of a plane of
// thickness t mass (t / h)^2 / (1 - nu^2), of a solid E V nu, and E V g.
using RegionMatter = std::array<double, 4>;

// s^2, b^2 of a plane, and nu and g of a solid, of a region that holds this much matter.
struct RegionRates {
    float rate_sq, bend_sq, poisson, volume_gain;
};
RegionRates rates_of(const RegionMatter& matter, int half_width, double h);

// The rates of all regions, and their Poisson's ratios where they are kept.
void find_rates(MatchedRegions& matched, const std::vector<RegionMatter>& matter, double h);

// What the regions of the slots that `which` says see of how their matter is spread: B^-1,
// with_spread, the twist of a plane's, and the volume where Poisson's ratios are kept. Others keep
// what they have.
void find_spread(MatchedRegions& matched, const Lattice& lattice, bool with_spread,
                 const std::function<bool(std::size_t)>& which);

// What belongs to regions, but for Poisson's ratios and volume; `with_spread`: B^-1 too.
MatchedRegions match_regions(LatticeRegions regions, const Lattice& lattice,
                             const std::vector<RegionMatter>& matter, double h, bool with_spread);

// Poisson's ratios and the volume of all regions of a solid.
void add_volume(MatchedRegions& matched, const Lattice& lattice,
                const std::vector<RegionMatter>& matter, double h);

}  // namespace physics
