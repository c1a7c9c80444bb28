#pragma once

// How a lattice lies around each of its corners, by the links that it has left.

#include "geometry/base/no_index.hpp"
#include "geometry/base/vec.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace geometry {

class CornerFrames {
public:
    // `after` says which corner a link leads to, 3 a corner, no_index where there is none; `broken`
    // which of those are gone, 3 * corner + axis. `size` is a link's length at rest, m.
    CornerFrames(std::vector<std::uint32_t> after, std::span<const std::uint32_t> broken,
                 double size);

    // A step along each axis of the lattice, column by column, m, with corners at x. What no link
    // says goes with what the others do: across them, or turned as one of them is.
    Mat3 at(std::uint32_t corner, std::span<const Vec3> x) const;

private:
    double size_;
    std::vector<std::uint32_t> after_, before_;  // 3 K, the corner linked there
};

}  // namespace geometry
