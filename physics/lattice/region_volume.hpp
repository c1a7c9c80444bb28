#pragma once

// How a region of a solid lattice keeps its volume, so that Poisson's ratio counts.
//
// With its best linear map F = A B^-1, B = sum M (X - C)(X - C)^T, and Q = det(B)^(1/6) B^-1/2,
// which has the determinant 1, a region is G = F Q^-1 in the metric of its masses, |G|^2 =
// det(B)^(-1/3) tr F B F^T. How far it is from the maps of determinant 1 is (det G - 1) / |cof G|
// to first order. It has the energy of
//   V(G) = (det G - 1)^2 / q,   q = |cof G|^2 + |G|^4 / 9 + 2
// times K det(B)^(1/3), beside k / 2 sum M |x - T_r X|^2 for its shape (lattice.hpp), and pulls its
// particles by k (T_r X - x) - K grad V Q (X - C_r):
//   grad V = 2 (r cof G - r^2 (11/9 |G|^2 G - G G^T G)),   r = (det G - 1) / q.
// At rest q is twice |cof G|^2, and V half the square of the distance. It turns with the region, so
// it pulls without force and torque, and it is smooth, also where the region is flat, a line or
// turned inside out. What q has beside |cof G|^2 bounds its second derivatives: 1 at rest, and -2
// to 1.4 over stretches of -7 to 7. So a pull by a share of up to 1 is stable, with the least
// damping of step_weights.cpp. (A pull to the
// nearest map of determinant 1, found by rounds and given up where they did not converge, is no
// gradient: single cubes turned inside out gained energy without bound. A pull by T X - x in place
// of (T - F)(X - C) resists the bends within a region too, K / k times as much.)
//
// Of small strains e shape and volume see tr(e B e) / 2 and (tr e)^2 / 2 tr B^-1. In a full region
// B = m2 M_r 1, and they are m2 M_r |e|^2 / 2 and m2 M_r (tr e)^2 / 6: a solid of
//   2 mu ~ k,  lambda ~ K / 3:   k = E / (1 + nu),   K = 3 nu / (1 - 2 nu) k,
// k and K rates like s^2 of lattice.hpp. Regions at borders have less lambda than others: bars thin
// by nu to 0.02, and a cube of 4 cubes, pressed from all sides, has 0.8 of its stiffness with w = 1
// and half with w = 2.
//
// Bends within a region need not cost what its stretch does (bend_ratio.hpp): with its stretch at
// the rate S = E / (1 + nu) it is pulled by (S - k) (R_r - F) (X - C_r) more, the force of
// (S - k) / 2 sum M |(F - R_r) (X - C_r)|^2. That has no force and no torque either, and K is that
// of S. Steps bear the larger of k and S, and K.
//
// Steps bear k dt^2 + K dt^2 of 1. Where a material asks for more, nu is what they can bear, and k
// is such that E is still right; in a bend E = k (x + phi nu) (make_lattice.cpp), k (1 + g nu) x.

#include "physics/lattice/matched_regions.hpp"

namespace physics {

// -grad V Q of A_r, along rest axes in lattice steps of edge h. `size`: the determinant that it has
// at rest, of a rest shape that has flowed.
template <class T>
Eigen::Matrix<T, 3, 3> pull_to_volume(const RegionVolume<T>& volume,
                                      const Eigen::Matrix<T, 3, 3>& a, T h, T size);

// F = A B^-1 of a region that has a volume, likewise.
template <class T>
Eigen::Matrix<T, 3, 3> linear_map(const RegionVolume<T>& volume, const Eigen::Matrix<T, 3, 3>& a,
                                  T h);

// From this q on, too large for single precision to go on with, nothing pulls.
inline constexpr float most_stretched = 1e36f;

}  // namespace physics
