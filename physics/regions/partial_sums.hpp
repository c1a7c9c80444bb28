#pragma once

// Sums over the regions that do not hold everything in their box, and back: from particles to bars,
// plates and regions, which are the nodes of PartialRegions. A node has four quads about its own
// place: S and its moments on the way up, a map on the way down.

#include "physics/regions/lattice_regions.hpp"
#include "physics/regions/quad.hpp"

#include <algorithm>

namespace physics {

// From `particles` to `nodes`; `flat` of a plane. T is float or double.
template <class T>
void collect_partial(const PartialRegions& e, bool flat, const Quad<T>* particles, Quad<T>* nodes);

// Back, added to `particles`; below the regions nodes are filled anew.
template <class T>
void spread_partial(const PartialRegions& e, bool flat, Quad<T>* nodes, Quad<T>* particles);

// Calls move(slot, node) with the quads of those regions whose slots are some of first .. last.
template <class T, class Move>
void for_partial_slots(const PartialRegions& e, Quad<T>* nodes, std::size_t first, std::size_t last,
                       const Move& move)
{
    auto i =
        std::size_t(std::lower_bound(e.region.begin(), e.region.end(), first) - e.region.begin());
    for (; i < e.region.size() && e.region[i] < last; ++i) {
        move(e.region[i], nodes + 4 * (e.bars + e.plates + i));
    }
}

}  // namespace physics
