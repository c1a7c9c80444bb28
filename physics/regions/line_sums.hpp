#pragma once

// Sums over sliding windows along lines, the one operation that all sums over regions are made of:
// particles to bars, bars to plates, plates to regions, and back. The time of a window does not
// depend on its width.
//
// Items are cut into blocks of 2w + 1. A window of 2w + 1 items lies across two blocks: it is a
// suffix sum of one and a prefix sum of the next (w = 2, the window in the middle at e):
//
//     | a  b [c  d  e | f  g] h  i  j |        [c d e] = suffix, kept from right to left
//            <------- w ------->               [f g]   = prefix, growing from left to right
//
// Nothing is ever subtracted, so no rounding drifts along the line, and one bad number stays in its
// window. (van Herk. A fast algorithm for local minimum and maximum filters. Pattern Recogn. Lett.
// 1992.) Windows up to w = 3 are added up item by item in single precision: what is near stays in
// registers. Two lines are summed at a time, a quad of each abreast in a vector.

#include "physics/math/aligned_memory.hpp"
#include "physics/regions/lattice_regions.hpp"

namespace physics {

// Lines along an axis: items of one, two and three quads, and their windows with one more, of a
// plane along y with two.
enum class Along { x, y, y_of_plane, z };

// Lines that are summed at the same time, where a vector holds a quad of each.
inline constexpr std::size_t most_abreast = 2;

// Some lines, begin .. end, and the window that their windows' numbers start with.
struct SomeLines {
    const LatticeLines& along;
    std::size_t begin, end;
    std::uint32_t window = 0;
};

// From items to windows: each becomes the sum of its items and their moments about its own place.
// Quads are four numbers one after another; `room` is used again from call to call. The bits do not
// depend on the processor. T is float or double.
template <class T>
void collect_some(Along axis, const SomeLines& lines, int w, const T* items, T* windows,
                  Aligned<T>& room);

// The transpose, from windows to items: each item becomes the sum of the maps of its windows, at
// its own place.
template <class T>
void spread_some(Along axis, const SomeLines& lines, int w, const T* windows, T* items,
                 Aligned<T>& room);

}  // namespace physics
