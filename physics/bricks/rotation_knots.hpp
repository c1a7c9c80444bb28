#pragma once

// Knots in the rotations of cubes, and rotations without them.
//
// Unit quaternions q and -q are one rotation. Go round an edge of the lattice, through the four
// cubes at it, and give each the sign that is nearest to the one before: in every motion that does
// not turn material inside out the first is met again with the sign that it had. Where a body was
// pushed through itself, the sign can come back changed: rows of cubes side by side are folded half
// a turn in opposite ways, and their ends agree again. Such a knot can't be undone by small moves:
// its line runs through the body until it leaves it at the surface. Each cube by itself is hardly
// strained (three quarters of its volume), so that forces balance, and the body would stay there
// for ever. Lines of this kind are known from crystals of rods (disclinations of strength one half;
// de Gennes, Prost. The physics of liquid crystals. 1993).
//
// They are undone by rotations that cubes are made to have for a frame. All signs are chosen along
// a tree of the neighbours that agree best. Neighbours whose signs do not fit then form a sheet
// that ends at the line of the knot; near it each quaternion becomes the mean of its own and those
// of its neighbours, several times. A cube that is held to a rotation is pulled to it with its
// linear stiffness, so that the rows fold the same way.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/pins.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace physics {

// For each cube, the one that shares its face towards +x, +y and +z, or no_index.
using CubeNeighbours = std::vector<std::array<std::uint32_t, 3>>;
CubeNeighbours find_neighbours(const geometry::Cubes& cubes);

struct HeldRotation {
    std::uint32_t cube = 0;
    std::array<float, 4> quaternion{};  // unit
};

// What cubes near knots are to be held to, ascending by cube; none where there is no knot.
// `rotation` holds four numbers a cube, a unit quaternion; other sizes have no knots. Faces that
// pins hold count as cubes that are turned as they are.
std::vector<HeldRotation> undo_knots(const geometry::Cubes& cubes, const CubeNeighbours& neighbours,
                                     const std::vector<float>& rotation, const Pins& pins);

}  // namespace physics
