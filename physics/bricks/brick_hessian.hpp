#pragma once

// Products with the second derivative of a brick's energy, geometric stiffness and all. In the
// symbols of brick_kernels.hpp, where dy = R^T dC is what a corner displacement changes:
//   R turns by     w,   (tr(S) I - S) w = sum_j e_j x dy_j
//   d changes by   dd = dy - w x Y        and K d by dF = K dd
//   q changes by   dq,  (tr(S) I - S) dq = sum_m (dd_m x F_m + d_m x dF_m) - (tr(dS) I - dS) q
// (with d + p in place of d in the last, where the rest shape has flowed)
//   the force changes by  -R (w x (F + E) + dF + dE),   dE_xj = e_j x dq,   dS = dd's linear part
// It is symmetric. Under compression it has negative directions, that K turned with the cube
// (R K R^T, add_stiffness_times) never has.
// Nesme, Payan, Faure. Efficient, physically plausible finite elements. Eurographics 2005 (the
// element); Barbic. Exact corotational linear FEM stiffness matrix. USC technical report 2012 (the
// same derivative, of tetrahedra).

#include "physics/bricks/brick_kernels.hpp"

namespace physics {

// What it needs beside the coefficients, whose stiffness carries a factor m = s + the damping of a
// cube. Rows of 16 lanes.
template <class T> struct BrickCurvature {
    const T* strained = nullptr;  // [block][strained_rows][16], of corotate()
    const T* share = nullptr;     // [block][16]: s / m
    T stiffness = 0;              // s
    T edge = 0;                   // m, four times that of a cube: C_x[x] at rest
    const T* plastic = nullptr;   // [block][plastic_rows][16], m; or null
};

// Adds (m R K R^T + s times the rest of the second derivative - N) p of blocks [begin, end) to q.
void add_hessian_times(const BrickCoefficients<float>& bricks,
                       const BrickCurvature<float>& curvature, std::size_t begin, std::size_t end,
                       const float* p, float* q);
void add_hessian_times(const BrickCoefficients<double>& bricks,
                       const BrickCurvature<double>& curvature, std::size_t begin, std::size_t end,
                       const double* p, double* q);

}  // namespace physics
