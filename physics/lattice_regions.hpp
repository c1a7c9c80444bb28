#pragma once

// The regions of lattice shape matching, and sums over them in constant time a particle.
// Rivers, James. FastLSM: fast lattice shape matching for robust real-time deformation. SIGGRAPH
// 2007.
//
// The region of a particle r is every particle that links reach from it inside the box of half
// width w around it. Two sums over regions make up a step:
//   collect: S_r = sum over i in r of f_i, and its moments sum (i - r)_d f_i along d = x, y, z
//   spread:  g_i = sum over r that hold i of (c_r + sum_d (i - r)_d R_d,r), its transpose
// with positions in lattice steps. Nearly all regions hold everything there is in their box. For
// those both sums go an axis at a time, along lines of the lattice: particles to bars, bars to
// plates, plates to regions, and back. A bar or plate is kept wherever a region needs it, also off
// the body, so holes and borders are exact. Each line is a sliding window, as suffix sums of one
// block of 2w + 1 and prefix sums of the next: nothing is ever subtracted, so no rounding drifts
// along the line, and one bad number stays in its window.
// (van Herk. A fast algorithm for local minimum and maximum filters. Pattern Recogn. Lett. 1992.)
// Narrow windows are added up item by item in single precision. Two lines are summed at a time, a
// quad of each abreast. Memory is what large lattices wait for: so a slice's bars become plates
// while they are near, and what regions make of their sums is spread where they lie, a few columns
// at a time.
//
// The other regions, where something in the box is not reached inside it (two prongs side by side),
// are summed from shared bars and plates of their own.
//
// A plane has no lines along its flat axis: plates are its regions. In the third moment's place
// they have that along both, sum (i - r)_x (i - r)_y f_i, and spread c_r + sum_d (i - r)_d R_d,r +
// (i - r)_x (i - r)_y Q_r.

#include "geometry/vec.hpp"
#include "physics/large_pages.hpp"

#include <functional>
#include <span>
#include <vector>

namespace physics {

using geometry::Vec3i;

inline constexpr std::uint32_t none = ~0u;

// Particles on a lattice. Any number may share a place: copies that are not linked.
struct Lattice {
    std::vector<Vec3i> at;                           // N, lattice coordinates
    std::vector<std::array<std::uint32_t, 3>> next;  // N, the particle linked in +x, +y, +z or none

    std::size_t count() const { return at.size(); }
};

// Sliding windows along one axis. The windows of a line lie at positions 0 .. windows - 1 and their
// values are consecutive; its items lie at lead .. lead + items - 1 and are looked up.
struct LatticeLines {
    struct Line {
        std::uint32_t window, windows;
        std::uint32_t item, items;  // into `items`
        std::int32_t lead;
    };
    std::vector<Line> lines;
    std::vector<std::uint32_t> items;  // none where there is a gap
    std::vector<std::uint32_t> dead;   // windows that nothing needs, they fill gaps between others
    std::uint32_t windows = 0;         // of all lines
};

// Where the lines of some slices across z end. What its lines along y sum are windows of its own
// lines along x.
struct LatticeSlab {
    std::uint32_t x_lines = 0, y_lines = 0;
};

// Regions that do not hold everything in their box, as sums of plates, those of bars, those of
// particles. Node n sums child[child_at[n] .. child_at[n + 1]]: bars come first and sum particles.
struct LatticeExceptions {
    std::uint32_t bars = 0, plates = 0;
    std::vector<std::uint32_t> region;             // slot of each region that is a node
    std::vector<Vec3i> at;                         // n, what its moments are about
    std::vector<std::uint32_t> child_at, child;    // n + 1
    std::vector<std::uint32_t> parent_at, parent;  // bars + plates + 1, into nodes
    std::vector<std::uint32_t> particle, bar_at;   // p, p + 1: particles with bars
    std::vector<std::uint32_t> bar;                // their bars * 256 + place in the bar

    std::size_t nodes() const { return at.size(); }
};

struct LatticeRegions {
    int half_width = 1;
    std::size_t particles = 0;
    bool flat = false;                 // of a plane
    std::array<int, 3> axes{0, 1, 2};  // of the lattice that lines x, y, z run along; z of a plane
                                       // is its flat one, without lines
    LatticeLines x, y, z;
    std::vector<LatticeSlab> slabs;
    LatticeExceptions exceptions;
    std::vector<std::uint32_t> particle;  // of each region slot; none for a gap

    std::size_t slots() const { return particle.size(); }
    std::size_t sides() const { return flat ? 2 : 3; }  // moments along `axes`
};

// `flat_axis` is one that nothing is linked along, or -1. Throws std::invalid_argument for a half
// width outside 1 .. 64, or links that are not to a neighbour, or along the flat axis.
LatticeRegions find_regions(const Lattice& lattice, int half_width, int flat_axis = -1);

// The lattice with its axes in the order that lines run along.
Lattice turned(const Lattice& lattice, const std::array<int, 3>& axes);

// How many regions hold each particle. N.
std::vector<std::uint32_t> count_holders(const LatticeRegions& regions);

// Four numbers that are added as one.
template <class T> using Quad = Eigen::Array<T, 4, 1>;

// Room for sums, reused from step to step.
template <class T> struct RegionSums {
    using Quads = std::vector<Quad<T>, LargePages<Quad<T>>>;

    Quads particles;  // N, where collect() wants f and spread() leaves g
    Quads bars, plates;
    std::vector<Quad<T>> exceptional;  // four a node of LatticeExceptions

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

}  // namespace physics
