#pragma once

// The arithmetic of the brick element, 16 cubes a block, in the Walsh-Hadamard basis: products with
// the stiffness, and the forces, rotations and stresses of bricks that turn with their material.
//
// A brick's corners a = 0..7 (drawn in brick_element.hpp) have signs s_a in {-1,1}^3. With C_m =
// sum_a s_a^m u_a over the monomials m in {1,x,y,z,xy,yz,zx,xyz}, the stiffness of an axis-aligned
// cube falls apart into tiny systems, one for each monomial n that a displacement gradient holds:
//   n = 1            the strain e(i,j) = C_xj[i] + C_xi[j]:  F_xj[i] = mu e(i,j) + lambda tr(C) 1ij
//   n = x, y, z      a third of the same in the plane across n: its traction on the planes along n
//                    is relaxed by the incompatible modes, which leaves plane stress,
//                    lambda' = 2 lambda mu / (lambda + 2 mu)
//   n = xy, yz, zx   together F_xyz = (4 mu + lambda) / 9 C_xyz
// and the corner forces are f_a = sum_m s_a^m F_m; mu and lambda carry the factor h / 16 (4 h from
// the integration, 1/8 from either transform). A plain trilinear brick has lambda' = lambda and
// mu C_xy[x] more in F_xy[x], and so on. A relaxed brick has lambda' in F_xyz, and of a one-point
// brick only n = 1 is as here (brick_element.hpp). Nothing of a cube is ever multiplied as a 24 x
// 24 matrix. Wilson, Taylor, Doherty, Ghaboussi. Incompatible displacement models. 1973. Taylor,
// Beresford, Wilson. A non-conforming element for stress analysis. IJNME 1976.
//
// Corotational: with R the rotation of the mean deformation gradient, d = R^T x - X and
//   W(x) = 1/2 d^T K d,   -dW/dx = -R (K d + E),
// where E accounts for the turning of R with x. Leaving E out (stiffness warping; Mueller, Gross.
// Interactive virtual materials. GI 2004) leaves a net torque, so that a bent body starts to spin.
// With t = sum_m d_m x F_m and S the stretch of Y = R^T F, the turning is
//   (tr(S) I - S) w = sum_j e_j x dy_j,   hence   E_xj = e_j x q,   (tr(S) I - S) q = t.
//
// A cube with a stiffness of its own (geometry::OwnElement) has a full matrix between the
// monomials of a field, F = H C. With W_a,m = s_a^m, f = W F and C = W^T u:  H = W^T K W / 64. Its
// N is full as well: mass / 64 times W^T (D - M) W, M the mass matrix for 1 kg and D its sums of
// rows. A block that holds any such cube has both for each of its lanes.
//
// Only operations that IEEE 754 rounds exactly are used, and no fused multiply-add: every processor
// gives the same bits.

#include "physics/bricks/brick_element.hpp"
#include "physics/math/aligned_memory.hpp"

#include <cstddef>
#include <cstdint>

namespace physics {

// Of H: 21 numbers of a field are x, y, z, xy, yz, zx, xyz, of each the components; its lower
// triangle lies row by row.
inline constexpr std::size_t field_numbers = 21, own_rows = 231;
inline constexpr std::size_t own_mass_rows = 28;  // of W^T (D - M) W, by monomials

// Elastic coefficients and rotations of all blocks. Each entry is a row of 16 lanes.
template <class T> struct BrickCoefficients {
    const std::uint32_t* gather = nullptr;   // [block][8][16]
    const std::uint32_t* scatter = nullptr;  // [block][8][16]
    // [block][3][16], times h / 16: mu, lambda and third_modulus() of the element
    const T* stiffness = nullptr;
    const T* rotation = nullptr;  // [block][9][16], row by row
    BrickElement element = BrickElement::incompatible;
    const T* excess = nullptr;  // [block][16]: m / 64, or null for none
    // [block], which of the matrices H it has, or no_index; null where none has.
    const std::uint32_t* own_at = nullptr;
    const T* own = nullptr;         // [own][own_rows][16], N/m
    const T* own_weight = nullptr;  // [own][16], factors on H; null for 1
    const T* own_mass = nullptr;    // [own][own_mass_rows][16]
};

// Lumped mass is mass / 64 of a cube on all C_m, and that of bricks the share w of that
// (physics/state/cube_mass.hpp). What lumping adds, N = mass / 64 (1 - w_m) on C_m, holds no C_1,
// and is the same however a cube is turned.

// Adds (R K R^T - N) p of blocks [begin, end) to q. Vectors have four numbers a slot, the fourth 0.
void add_stiffness_times(const BrickCoefficients<float>& bricks, std::size_t begin, std::size_t end,
                         const float* p, float* q);
void add_stiffness_times(const BrickCoefficients<double>& bricks, std::size_t begin,
                         std::size_t end, const double* p, double* q);

// Adds N p of blocks [begin, end) to q. Only gather, scatter, excess, own_at and own_mass are read.
void add_excess_times(const BrickCoefficients<double>& bricks, std::size_t begin, std::size_t end,
                      const double* p, double* q);

// Rows a block of what brick_hessian.hpp needs of strained cubes: the monomials of the displacement
// by component (21), (tr(S) I - S)^-1 (6) and q (3).
inline constexpr std::size_t strained_rows = 30;

// Where its rest shape has flowed (brick_flow.hpp), a brick has d = R^T x - X - p, with p in the
// monomials x, y, z, of which it is symmetric (xx xy xz yy yz zz), xy, yz, zx and xyz (x, y and z
// of each). What R turns is still all of R^T x: t = sum_m (d + p)_m x F_m.
inline constexpr std::size_t plastic_rows = 18;

// What corotate() reads and fills; null where not wanted. Rows of 16 lanes.
struct Corotation {
    double h = 0;                      // m, edge of a cube
    const double* held = nullptr;      // [block][16], 1: keeps last time's rotation; or null
    const double* plastic = nullptr;   // [block][plastic_rows][16], m, p; or null
    double* quaternion = nullptr;      // [block][4][16], in: last time's; out: this time's
    double* rotation = nullptr;        // [block][9][16]
    float* rotation_low = nullptr;     // [block][9][16], the same in single precision
    double* force = nullptr;           // slots x 4, the elastic force is added
    double* strained = nullptr;        // [block][strained_rows][16]; needs `force`
    float* strained_low = nullptr;     // the same in single precision; with `strained`
    float* stress = nullptr;           // [block][16], von Mises, of `material`
    const double* material = nullptr;  // [block][2][16]: mu, lambda, Pa; for stress
    float* volume = nullptr;           // [block][16], of the mean deformation: 1 at rest
    float* energy = nullptr;           // [block][16], J
};

// The rotations, elastic forces and stresses of blocks [begin, end) with corners at x. Returns
// their elastic energy, in J. `bricks.rotation` is not read.
double corotate(const BrickCoefficients<double>& bricks, const Corotation& at, std::size_t begin,
                std::size_t end, const double* x);

}  // namespace physics
