#pragma once

// The regions of lattice shape matching, laid out so that sums over them take constant time a
// particle, whatever their width. Plain data: find_regions.hpp makes it, region_sums.hpp uses it.
// Rivers, James. FastLSM: fast lattice shape matching for robust real-time deformation. SIGGRAPH
// 2007.
//
// The region of a particle r is every particle that links reach from it inside the box of half
// width w around it. Nearly all regions hold everything there is in their box. For those, sums go
// an axis at a time, along lines of the lattice (w = 1, so three of each):
//
//     particles        bar              plate            region
//     . . . . .        2w + 1           2w + 1           2w + 1
//     . . . . .        particles        bars             plates
//     . . . . .        along x          along y          along z
//                                                          +-------+
//                                       +-------+         /|      /|
//                      +-------+        | . . . |        +-------+ |
//                      | . . . |        | . . . |        | . . . | |
//                      +-------+        | . . . |        | . . . | +
//                                       +-------+        | . . . |/
//                                                        +-------+
//
// A bar or plate is kept wherever a region needs it, also off the body, so holes and borders are
// exact. The way back, from regions to particles, goes along the same lines.
//
// The others, where something in the box is not reached inside it (two prongs side by side), are
// PartialRegions: they are summed from bars and plates of their own, which they share.
//
//      #  #      The box of r (w = 1) holds six particles. Those of the right prong are linked
//      r  #      to r only below, outside the box: they are not in its region.
//      #  #
//      #--#
//
// A plane has no lines along its flat axis: plates are its regions. In the third moment's place
// they have that along both, sum (i - r)_x (i - r)_y f_i.

#include "physics/regions/links.hpp"

namespace physics {

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
struct PartialRegions {
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
    PartialRegions partial;
    std::vector<std::uint32_t> particle;  // of each region slot; none for a gap

    std::size_t slots() const { return particle.size(); }
    std::size_t sides() const { return flat ? 2 : 3; }  // moments along `axes`
};

}  // namespace physics
