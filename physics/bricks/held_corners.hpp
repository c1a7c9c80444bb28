#pragma once

// Which corners the linear equations of a step hold, wholly or along some axes of the world, and
// which springs hold the material between corners.

#include "geometry/base/vec.hpp"
#include "physics/body/corner_body.hpp"
#include "physics/bricks/brick_element.hpp"
#include "physics/state/loads.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace physics {

struct HeldCorners {
    std::vector<std::uint32_t> whole;                           // sorted
    std::vector<std::pair<std::uint32_t, std::uint8_t>> along;  // sorted; axes as Pins has them
    std::vector<HeldCube> matter = {};                          // by cube, which add to the matrix
    bool operator==(const HeldCorners&) const = default;
};

// Orders springs by their cubes.
struct ByCube {
    bool operator()(const HeldCube& a, std::size_t c) const { return a.cube < c; }
    bool operator()(std::size_t c, const HeldCube& a) const { return c < a.cube; }
};

HeldCorners held_by(const Pins& pins);

// The axes along which each of so many corners is held.
std::vector<std::uint8_t> axes_by_corner(const HeldCorners& held, std::size_t corners);

// The axes along which each part of a body is held by anything.
std::vector<std::uint8_t> axes_of_parts(const Pins& pins, const CornerBody& body);

// matrix += weight * the springs of a cube, between its 8 corners.
void add_held(const HeldCube& cube, double weight, BrickMatrix& matrix);

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
