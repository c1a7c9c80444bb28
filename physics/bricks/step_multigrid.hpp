#pragma once

// Multigrid as the preconditioner of a stage's linear equations: smooths A of the stage itself over
// the cubes, with their rotations and contacts as they are, and leaves the rest to the coarse grids
// of the method at rest (multigrid.hpp), turned with the corners.
//   z = S r;  z += P A_c^-1 P^T (r - A z);  z += S (r - A z)
// with S a Chebyshev polynomial in D^-1 A, D the diagonal of A with its blocks. I - M^-1 A is then
// S' (I - C A) S' with S' = I - S A and C positive: M is positive definite whatever the coarse
// grids know of A, as long as the eigenvalues of D^-1 A are where the smoother takes them to be.

#include "physics/bricks/elasticity.hpp"
#include "physics/bricks/multigrid.hpp"
#include "physics/math/conjugate_gradients.hpp"

namespace physics {

struct StepMultigrid {
    std::vector<ChebyshevStep> smoother = {};
    std::vector<std::uint32_t> held_along = {};  // numbers that are held one by one
    Aligned<float> rest, change, product;        // work

    // `largest` bounds the eigenvalues of D^-1 A from above.
    void start(double largest);
    // z = M^-1 r. `system` is A, `elasticity` holds its coarse grids.
    void apply(const LinearSystem<float>& system, Elasticity& elasticity, const float* r, float* z);
};

}  // namespace physics
