#pragma once

// The two sums over regions that make up a step of shape matching, in constant time a particle:
//   collect: S_r = sum over i in r of f_i, and its moments sum (i - r)_d f_i along d = x, y, z
//   spread:  g_i = sum over r that hold i of (c_r + sum_d (i - r)_d R_d,r), its transpose
// with positions in lattice steps. Of a plane the third moment is along both axes, sum (i - r)_x (i
// - r)_y f_i, and what is spread is c_r + sum_d (i - r)_d R_d,r + (i - r)_x (i - r)_y Q_r.
//
//     particles --x--> bars --y--> plates --z--> slots of regions      collect
//     particles <--x-- bars <--y-- plates <--z-- slots of regions      spread
//
// Memory is what large lattices wait for. So the bars of a slab, a few slices, become plates while
// they are near, and what regions make of their sums is spread where they lie, a few columns at a
// time: slots never go out to memory.

#include "physics/math/large_pages.hpp"
#include "physics/regions/lattice_regions.hpp"
#include "physics/regions/quad.hpp"

#include <functional>
#include <span>

namespace physics {

// Room for sums, reused from step to step.
template <class T> struct RegionSums {
    using Quads = std::vector<Quad<T>, LargePages<Quad<T>>>;

    Quads particles;  // N, where collect() wants f and spread() leaves g
    Quads bars, plates;
    std::vector<Quad<T>> partial;  // four a node of PartialRegions

    explicit RegionSums(const LatticeRegions& regions);
};

// Is given the quads of some slots, from `first` on, four each: S and its moments along `axes`, of
// a plane along two and their product; or, to be spread, room for c and the R (and Q). Those of
// slots without a particle are zero, and whatever is left there is not spread. Called once for each
// slot, by several threads at a time.
template <class T>
using SlotVisit = std::function<void(std::size_t first, std::span<Quad<T>> slots)>;

template <class T>
void collect(const LatticeRegions& regions, RegionSums<T>& sums, const SlotVisit<T>& visit);
template <class T>
void spread(const LatticeRegions& regions, RegionSums<T>& sums, const SlotVisit<T>& visit);
// Both, with what `visit` makes of each sum in its place: no slot ever goes out to memory.
template <class T>
void collect_and_spread(const LatticeRegions& regions, RegionSums<T>& sums,
                        const SlotVisit<T>& visit);

// How many regions hold each particle. N.
std::vector<std::uint32_t> count_holders(const LatticeRegions& regions);

}  // namespace physics
