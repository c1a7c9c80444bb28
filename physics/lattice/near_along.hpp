#pragma once

// Which particles of a body are near each other along it. Contact of the body with itself leaves
// these to its stiffness, and keeps all others apart:
//
//     o---o---o---o---o---o      a and b lie on each other and are eleven links apart: they touch.
//     |       a           |      a and its neighbours to both sides do not.
//     o---o---o---o---o---o
//             b

#include "physics/regions/links.hpp"

namespace physics {

class NearAlong {
public:
    NearAlong() = default;

    // Of the particles `side`: those at most `links` links apart, and those that rest nearer to
    // each other than `distance` (in cubes), as over a slit, with their neighbours: they
    // would push from the start, or as soon as one lip slides along the other.
    NearAlong(const Lattice& lattice, const std::vector<std::uint32_t>& side, int links,
              double distance);

    bool has(std::uint32_t a, std::uint32_t b) const;

    std::size_t bytes() const;

private:
    std::vector<std::uint32_t> at_;    // N + 1, into near_
    std::vector<std::uint32_t> near_;  // of each, in rising order
};

}  // namespace physics
