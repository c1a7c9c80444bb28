#pragma once

// The mass of a cube of finite element bricks, as its corners carry it. With s_a the signs of
// corner a, xi in -1..1 and the monomials m in {1, x, y, z, xy, yz, zx, xyz},
//   v(xi) = sum_m c_m xi^m,   c_m = 1/8 sum_a s_a^m v_a,   T = mass / 2 sum_m w_m |c_m|^2
// where w depends on the degree d of m alone. Integrated exactly, w = 3^-d (consistent mass). An
// eighth at each corner is w = 1 (lumped mass): a cube then resists turning three times as much as
// it should, and waves run too slowly. Lumped mass is what lattice and springs have; bricks have
// `mass_shares`. Whatever they are, w of degree 0 is 1: weight, momentum and centre are those of
// lumped mass, and since |c_m|^2 does not change when all v turn, so is the mass of a turned cube.

#include "geometry/cubes/cubes.hpp"

#include <array>
#include <vector>

namespace physics {

using geometry::Vec3;

// w by degree. That of degree 1 is what a cube resists turning by, and is close to 1/3: a body n
// cubes thick has 1 + (3 w_1 - 1) / n^2 times its inertia. The rest of 3 w_1 - 1 = 0.078 makes up
// for half of what a bar one cube thick is too stiff in torsion. Each degree more takes 2/3,
// halfway between lumped (1) and consistent (1/3) mass, where the error of a wave along the cubes
// is of fourth order in the wave number (Goudreau, Taylor. Evaluation of numerical integration
// methods in elastodynamics. 1973).
inline constexpr double turning_share = 0.3593;
inline constexpr std::array<double, 4> mass_shares{1, turning_share, turning_share * 2 / 3,
                                                   turning_share * 4 / 9};

// The mass matrix of a cube of 1 kg between its corners, the same for x, y and z.
using CubeMass = std::array<std::array<double, 8>, 8>;
CubeMass cube_mass_matrix();

// That of cube c for 1 kg, `usual` where it has no element of its own.
CubeMass mass_of_cube(const geometry::Cubes& cubes, std::size_t c, const CubeMass& usual);

// M v, v and the result by corner, of cubes that are bricks.
std::vector<Vec3> brick_momenta(const geometry::Cubes& cubes, const std::vector<Vec3>& v);

}  // namespace physics
