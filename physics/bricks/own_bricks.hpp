#pragma once

// Cubes with a stiffness of their own (geometry::OwnElement) among the bricks of a body.

#include "physics/body/stiffness.hpp"
#include "physics/bricks/brick_element.hpp"
#include "physics/bricks/brick_layout.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/state/cube_mass.hpp"

#include <array>
#include <vector>

namespace physics {

// The blocks with a cube that has a stiffness of its own: a matrix H (brick_kernels.hpp) for each
// lane.
struct OwnBricks {
    std::vector<std::uint32_t> at;  // B, which it is, or no_index; empty: no block has any
    std::size_t blocks = 0;
    Aligned<double> matrices;     // blocks x own_rows x 16, N/m
    Aligned<float> matrices_low;  // the same in single precision
    Aligned<double> mass;         // blocks x own_mass_rows x 16
    Aligned<float> mass_low;
};

// The matrices of blocks that have such a cube, 0 of cubes that are `rigid` (empty: none is).
// `edge` is that of the cubes of each block, m.
OwnBricks make_own_bricks(const geometry::Cubes& cubes, const BrickLayout& layout,
                          const std::vector<double>& edge, BrickElement element,
                          Weighting weighting, const std::vector<std::uint8_t>& rigid = {});

// The largest number of each corner's part of the diagonal, for a Young's modulus of 1 Pa and an
// edge of 1 m.
std::array<double, 8> corner_diagonal(const BrickMatrix& k);

// Of D^-1 K, D with the corners' numbers above.
double largest_eigenvalue(const BrickMatrix& k);

// Of D^-1 M, D the diagonal of M.
double largest_eigenvalue(const CubeMass& m);

}  // namespace physics
