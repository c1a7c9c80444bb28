#pragma once

// Interpolation between the corners of a grid and the nodes of a coarser one, for multigrid.
//
// Nodes move by t and turn by w (coarse_grid.hpp). A corner in place p of its coarse cell, 0 .. 1
// along each axis, moves by the trilinear mean of what its eight nodes make of it:
//   u(p) = sum_a weight_a(p) (t_a + w_a x (p - a)),   P: t, w -> u
// As a polynomial in p that is, with m over the monomials x^i y^j z^k of 0 and 1,
//   u(p) = sum_m m(p) (t_m + w_m x p)
// and along a line of corners, where y and z stay, one of degree two in x: so a corner takes three
// multiplications by vectors, and not eight of t and of w. P^T goes the same way back: moments of
// the forces along a line, lines to monomials, monomials to nodes.

#include "physics/bricks/coarse_grid.hpp"
#include "physics/math/aligned_memory.hpp"

namespace physics {

// Rotations of corners that turn with the material: three rows of four numbers for each corner of
// the grid, the fourth 0. Null: none turns.
using CornerTurns = const float*;

// Forces on nodes, six numbers each, of forces on corners, r: four numbers a slot. `by_cell`: room.
void restrict_corners(const CoarseGrid& grid, std::span<const geometry::Vec3i> corner,
                      const float* r, const std::uint32_t* slot, CornerTurns turns,
                      Aligned<float>& by_cell, Aligned<float>& by_node);

// z += P of motions of nodes.
void prolong_corners(const CoarseGrid& grid, std::span<const geometry::Vec3i> corner,
                     const float* by_node, const std::uint32_t* slot, CornerTurns turns, float* z);

// The same between nodes and those of the next grid, where r, d and z have six numbers a node, and
// d = P of the motions, z += d.
void restrict_nodes(const CoarseGrid& grid, std::span<const geometry::Vec3i> node, const float* r,
                    Aligned<float>& by_cell, Aligned<float>& by_node);
void prolong_nodes(const CoarseGrid& grid, std::span<const geometry::Vec3i> node,
                   const float* by_node, float* d, float* z);

}  // namespace physics
