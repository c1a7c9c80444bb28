#pragma once

// Cubes that a tear has parted. Each corner of a cube stands for the octant of the cube around it.
// Where the links that a cube has left no longer join all of its corners, it is in parts: the
// octants of those that are still joined.
//
//      2 --- 3          2     3        Seen along one axis: with the links 0-1 and 2-3 broken
//      |     |          |  :  |        (and those behind them), the cube is in two parts, {0, 2}
//      |     |    ->    |  :  |        and {1, 3}. The mesh is cut along the plane between them,
//      |     |          |  :  |        dotted.
//      0 --- 1          0     1
//
// Links are named 3 * corner + axis, ascending, by the lower of their two corners.

#include "geometry/cubes/cubes.hpp"

#include <span>

namespace geometry {

// A cube in parts: the part of each corner, numbered from 0.
struct PartedCube {
    std::uint32_t cube;
    std::array<std::uint8_t, 8> part;
    std::uint8_t parts;
};

// Those whose corners are no longer all joined, in the order of the cubes. Of cubes that share a
// cell only the first can be one, as meshes are bound to that.
std::vector<PartedCube> find_parted(const Cubes& cubes, std::span<const std::uint32_t> broken);

// Which cubes those are. C.
std::vector<std::uint8_t> marked(const Cubes& cubes, std::span<const PartedCube> parted);

// The cells of parted cubes, in their order.
std::vector<Vec3i> cells_of(const Cubes& cubes, std::span<const PartedCube> parted);

}  // namespace geometry
