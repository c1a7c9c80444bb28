#pragma once

// Which corners the parts of parted cubes share. Each part has eight: its own, and virtual ones in
// place of the others (part_motion.hpp).
//
//      2 ----- 3 ----- 5      The links 0-2 and 1-3 are broken, and 4-5 is not: the left cube is in
//      |       |       |      two parts, {0, 1} and {2, 3}, and the right one is whole.
//      | . . . |       |
//      |       |       |
//      0 ----- 1 ----- 4
//
// Two cubes that share a face are joined at each corner of it: the parts that have that corner
// share all four corners of the face. Here both parts have corners 1 and 3, so that they meet on
// the face of the whole cube, where the tear ends. The motion is continuous wherever material is,
// and closed surfaces stay closed.
// After Molino, Bao, Fedkiw. A virtual node algorithm for changing mesh topology during simulation.
// SIGGRAPH 2004.

#include "geometry/embed/parted_cubes.hpp"

namespace geometry {

struct PartCorners {
    // Of all parts of the first parted cube, of the second, ...: numbers of its corners.
    std::vector<std::array<std::uint32_t, 8>> of;
    // The cubes' corner that each number stands for; no_index: it is virtual, or no number in use.
    std::vector<std::uint32_t> own;
};

// `parted` as find_parted() has it.
PartCorners corners_of_parts(const Cubes& cubes, std::span<const PartedCube> parted);

}  // namespace geometry
