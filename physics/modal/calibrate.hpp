#pragma once

// Cubes that bend as the thin or tilted thing within them does: numerical coarsening.
//
// A cube that is partly filled is far too stiff where what it holds is thin: its trilinear field
// cannot bend within it. The body is solved once on fine cubes, and each partly filled cube gets
// the stiffness that gives the fine cubes' energy in the motions found there. With
//   phi_k   the lowest free modes of the fine cubes, and their displacements under body forces
//           that are linear in position (which stretch and shear),
//   q_k     the motion of the corners that follows phi_k best, by least squares over the material,
//           with a little stiffness so that corners far from it move smoothly,
//   N       the trilinear motion of the fine cubes by a cube's corners,
// of one cube:
//   K = sum N^T K_fine N   (quadrature; positive, and stays what it is in all other motions)
//   E = phi^T K_fine phi,  Q = [q],   T with T^T Q^T K Q T = 1
//   K' = K - Y Y^T + Y (T^T E T) Y^T,   Y = K Q T
// K' is positive, symmetric, resists no rigid motion, and has the energy E in the motions Q: as
// K Q = Y T^-1,  Q^T K' Q = T^-T (T^T E T) T^-1 = E. Full cubes keep their own. A body's cubes get
//   factor ((1 - share) K' + share K)
// where share and factor bring its lowest six modes to those of its fine cubes: K' alone is soft in
// motions that are not among the phi, in some bodies more so in one direction than in another.
//
// In the spirit of Kharevych, Mullen, Owhadi, Desbrun. Numerical coarsening of inhomogeneous
// elastic materials. SIGGRAPH 2009; Chen, Levin, Sueda, Matusik. Data-driven finite elements for
// geometry and material design. SIGGRAPH 2015.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/state.hpp"

namespace physics {

struct FineCubes {
    const geometry::Cubes& cubes;
    int ratio = 4;  // of them along the edge of a cube, from the same origin
};

struct CalibrationSettings {
    // Of each body that hangs together. With the six displacements they are as many motions as a
    // cube has; with more, cubes follow each of them less well, and become too soft.
    int modes = 12;
};

// `coarse` with an element of its own for each cube that is not full, and the fill and the mass of
// the fine cubes there. Both are made of the same geometry and matter, with pieces apart in both
// or in neither; fine cells lie in cells of `coarse`. The report says whether the fine solves
// converged. Throws std::invalid_argument when more than a hundredth of the fine mass lies
// elsewhere.
geometry::Cubes calibrated(const geometry::Cubes& coarse, const FineCubes& fine,
                           const CalibrationSettings& settings, Report& report);

}  // namespace physics
