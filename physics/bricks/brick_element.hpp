#pragma once

// The stiffness of one cube, linear and alone, as a 24 x 24 matrix: for assembled matrices, and as
// the reference that the vectorised kernels are checked against.
//
//        2--------3
//       /|       /|         y          corner a: bit 0 of a is its x, bit 1 its y, bit 2 its z
//      6--------7 |         |
//      | 0------|-1         o---- x
//      |/       |/         /
//      4--------5         z
//
// In the Walsh-Hadamard basis c_m = (1/8) sum_a s_a^m u_a over the monomials m = 0..7 (bit 0: x,
// bit 1: y, bit 2: z; s_a the corner's signs), each monomial n that a gradient can hold has
//   G_n(i,j) = (2/h) c_{n x_j}[i] where x_j does not divide n, else 0
//   P_n = mu (G_n + G_n^T) + lambda tr(G_n) I      w_n = h^3 / 3^(degree of n)
// and adds w_n (2/h) P_n(.,j) to monomial n x_j. This equals 2x2x2 Gauss integration.
// The incompatible element adds the nine bubbles (1 - xi_d^2) and condenses them, so that bending
// does not lock: Wilson, Taylor, Doherty, Ghaboussi. Incompatible displacement models. 1973;
// Taylor, Beresford, Wilson. A non-conforming element for stress analysis. IJNME 1976. In this
// basis they only choose the missing column G_n(., d) of n = x_d so that the traction P_n(., d)
// vanishes. What is left to lock where the matter is nearly incompressible is the volume of the
// hourglass xyz, lambda tr(G_n) of n = xy, yz, zx: a bar in torsion. The relaxed element has
// lambda' = 2 lambda mu / (lambda + 2 mu) there, as in bending: the volume of these three modes is
// free, as with the three volumetric modes of Simo, Armero, Taylor. Improved versions of assumed
// enhanced strain tri-linear elements for 3D finite deformation problems. CMAME 110, 1993. All that
// is linear stays as it is, so that it passes the patch test.
// The one-point element is that of finite differences: the gradient is the central difference of
// the corners about the cube's middle, and what that does not see, the twelve hourglasses, resist
// one by one, each with a stiffness of its own (Flanagan, Belytschko. A uniform strain hexahedron
// and quadrilateral with orthogonal hourglass control. IJNME 17, 1981). With C and F as in
// brick_kernels.hpp, F_nx_j[i] is E / 3 C for i along one of the monomial's own axes, which is a
// bar's bending, mu / 3 C across them, which is its torsion, and 4 mu / 9 C for xyz. Nothing of it
// locks at any Poisson ratio. A plate one cube thick is 1 - nu^2 as stiff as it should be where it
// bends one way, 1 - nu where it bends both ways, and 3/4 where it twists. Its mass is lumped.

#include "geometry/cubes/cubes.hpp"

namespace physics {

enum class BrickElement { incompatible, trilinear, one_point, relaxed };

// The element that a body of these cubes has where `asked` is: incompatible becomes relaxed where
// any cube's Poisson ratio is above 0.45.
BrickElement element_of(const geometry::Cubes& cubes, BrickElement asked);

struct Lame {
    double lambda, mu;  // Pa
};
Lame lame(double young, double poisson);
// The third number of an element's stiffness, beside mu and lambda, Pa: lambda' = 2 lambda mu /
// (lambda + 2 mu), of trilinear bricks lambda, of those of one point Young's modulus.
double third_modulus(Lame material, BrickElement element);

using BrickVector = Eigen::Matrix<double, 24, 1>;   // corner a's x, y, z at 3a, 3a + 1, 3a + 2
using BrickMatrix = Eigen::Matrix<double, 24, 24>;  // symmetric, positive semi-definite

// K u, N: the elastic forces' opposites at the corners of a cube of edge h (m) displaced by u (m).
BrickVector brick_forces(const BrickVector& u, double h, Lame material,
                         BrickElement element = BrickElement::incompatible);

// K, N/m.
BrickMatrix brick_stiffness(double h, Lame material,
                            BrickElement element = BrickElement::incompatible);

// K of an element, N/m, for a Young's modulus of 1 Pa and an edge of 1 m. Rigid motions, which
// single precision resists a little, are taken out.
BrickMatrix stiffness_of(const geometry::OwnElement& element);
std::array<float, 300> lower_triangle(const BrickMatrix& k);

}  // namespace physics
