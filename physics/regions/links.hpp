#pragma once

// Particles on a grid of integer places, and the links between neighbours. Regions are found along
// these links alone: particles beside each other that are not linked do not see each other.
//
//     y
//     |   3     4---5         next[0] = {1, 3, none}      next[3] = {none, none, none}
//     |   |     |             next[1] = {2, 4, none}      next[4] = {5, none, none}
//     |   0-----1---2         next[2] = {none, ...}: 2 and 5 lie beside each other, but are not
//     +------------- x                             linked, and 3 and 4 likewise

#include "geometry/base/no_index.hpp"
#include "geometry/base/vec.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace physics {

using geometry::Vec3i;

inline constexpr std::uint32_t none = geometry::no_index;

// Particles on a lattice. Any number may share a place: copies that are not linked.
struct Lattice {
    std::vector<Vec3i> at;                           // N, lattice coordinates
    std::vector<std::array<std::uint32_t, 3>> next;  // N, the particle linked in +x, +y, +z or none

    std::size_t count() const { return at.size(); }
};

// Which linked piece each particle is of. Pieces are numbered by their first particles.
struct LinkedPieces {
    std::vector<std::uint32_t> of;  // N
    std::size_t count = 0;
};

// The pieces that links hold together, but for the links `broken`: 3 i + axis, in rising order.
LinkedPieces linked_pieces(const Lattice& lattice, const std::vector<std::uint32_t>& broken = {});

// The lattice with its axes in the order that lines run along.
Lattice turned(const Lattice& lattice, const std::array<int, 3>& axes);

}  // namespace physics
