#pragma once

// Which corners the linear equations of a step hold, wholly or along some axes of the world.

#include "geometry/base/vec.hpp"
#include "physics/state/loads.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace physics {

struct HeldCorners {
    std::vector<std::uint32_t> whole;                           // sorted
    std::vector<std::pair<std::uint32_t, std::uint8_t>> along;  // sorted; axes as Pins has them
    bool operator==(const HeldCorners&) const = default;
};

HeldCorners held_by(const Pins& pins);

// The axes along which each of so many corners is held.
std::vector<std::uint8_t> axes_by_corner(const HeldCorners& held, std::size_t corners);

// A block of a symmetric matrix between two corners, less what ties held axes to others: what is
// solved for of the free ones then does not see them. Of a corner with itself, the diagonal stays.
template <class Block>
geometry::Mat3 without_held(const Block& block, std::uint8_t rows, std::uint8_t columns, bool own)
{
    geometry::Mat3 out = block;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            if (((rows >> i | columns >> j) & 1) != 0 && !(own && i == j)) out(i, j) = 0;
        }
    }
    return out;
}

}  // namespace physics
