#pragma once

// Which frames of a shot to show, where something happens.

#include "render/image.hpp"

#include <span>
#include <vector>

namespace render {

// How much each picture differs from the one before: the mean over its pixels of the channel that
// differs most, 0..255. As many as pictures, the first 0. Throws std::invalid_argument for pictures
// of different sizes.
std::vector<double> changes_of(std::span<const Image* const> pictures);

// Places of at most `count` of the pictures, the first and the last among them, with as equal a sum
// of `changes` from each to the next as may be; evenly spread, where nothing changes. Fewer where
// fewer differ.
std::vector<std::size_t> spread_by_change(std::span<const double> changes, std::size_t count);

// Places of at most `count` of the values: the first, the last, and those where the value turns,
// the greatest swings first; what is left over parts the greatest differences. A value that is not
// finite stands for the one before.
//   Of the turns, the pair with the least swing between them is left out again and again: what
//   remains are those of greatest persistence (Edelsbrunner, Letscher, Zomorodian. Topological
//   persistence and simplification. Discrete & Computational Geometry 28, 2002).
std::vector<std::size_t> extremes_of(std::span<const double> values, std::size_t count);

}  // namespace render
