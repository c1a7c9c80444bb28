#pragma once

// Rest shapes of bricks that give way (state/plastic.hpp).
//
// The mean of a brick has U = R^T F, with F its mean deformation gradient, and the rest shape S, of
// the volume 1. Its forces are linear in U - S. It yields by what of that is no change of volume,
// as metals and clay do, and S grows by a share of it: under pressure from all sides nothing flows.
// What else a brick does, its bending and twisting (the monomials xy, yz, zx and xyz of
// brick_kernels.hpp, over 4 h), gives way by the same share: a wall one cube thick that is bent
// over stays so. The strain that it yields by is the root of the mean square in the brick, which of
// a monomial x is a third and of xy a ninth of its square; as the incompatible element has it, x
// strains the plane across x alone.
//
// The rest shape moves what the element's forces are linear about; its stiffness stays that of the
// cube. So preconditioners and factors hold as they are.

#include "geometry/base/vec.hpp"
#include "physics/state/plastic.hpp"

namespace physics {

// Strains: symmetric, or U and S less I, of the mean; x, y, z by row of xy, yz, zx, xyz.
struct BrickStrain {
    geometry::Mat3 mean = geometry::Mat3::Zero();
    Eigen::Matrix<double, 3, 4> bent = Eigen::Matrix<double, 3, 4>::Zero();
};

// The root of the mean square.
double size_of(const BrickStrain& strain);

// What the rest shape of a brick has come to that is `now`, after dt seconds. Its strain may be a
// little beyond the limit, as its volume is kept.
BrickStrain flowed(const BrickStrain& rest, const BrickStrain& now, const PlasticOptions& options,
                   double dt);

}  // namespace physics
