#pragma once

// The linear equations of one Newton round of a stage, A delta = r (see stage.hpp), and the norm
// that all residuals of a stage are measured in.
//
// They are solved by conjugate gradients in single precision, again on what that leaves over where
// it is not enough, and in double where single gets nowhere. The preconditioner is the inverse of
// A's diagonal, with a 3 x 3 block at each corner that touches something:
//   |r| = sqrt(r . P r),   P = that inverse
// In stiff bodies A at rest, factored once, takes its place (corner_factor.hpp), where it takes
// many iterations with the contacts added (step_responses.hpp); in large ones multigrid
// (step_multigrid.hpp). Where these should take longer than to factor A as it is, or have
// taken half as long and not got there, A is factored (step_direct.hpp). What should take how long
// is counted from the matrix's structure, in products with A: no result depends on a clock.
// Rigid parts are solved with each other at once (rigid_system.hpp), beside the elastic ones.

#include "physics/bricks/contact_block.hpp"
#include "physics/bricks/joined_system.hpp"
#include "physics/bricks/rigid_system.hpp"
#include "physics/bricks/stage.hpp"
#include "physics/bricks/step_direct.hpp"
#include "physics/bricks/step_multigrid.hpp"
#include "physics/bricks/step_responses.hpp"
#include "physics/math/conjugate_gradients.hpp"

#include <cstdint>
#include <vector>

namespace physics {

// A in one precision, and the vectors that its solves work in.
template <class T> struct StepSystem {
    LinearSystem<T> linear;
    std::vector<ContactBlock<T>> contacts;
    ConjugateVectors<T> work;
};

// Kept from round to round for its room.
struct StepSolver {
    explicit StepSolver(const Stage& stage);

    StepSystem<float> low;
    StepSystem<double> high;
    StepMultigrid multigrid;
    StepDirect direct;
    StepResponses responses;
    RigidSystem rigid;
    JoinedSystem joined;     // with what is elastic, as `direct` has it
    Aligned<double> lumped;  // with rigid parts: the diagonal of A but for K and contacts
    int took = 0;            // iterations of the last solve in single precision
    Aligned<float> loose;    // a residual without what is held along an axis
    Aligned<double> rest;    // N s, r - A delta
    std::vector<std::uint32_t> block_of;  // of each slot while blocks are added up
};

// Takes A's diagonal and its blocks from the stage as it was linearised and touches. Whoever wants
// a norm or a solution calls this first.
void prepare(StepSolver& solver, const Stage& stage);

double norm(const StepSolver& solver, const Aligned<double>& r);
// The same of each part's corners alone.
std::vector<double> norms_of_parts(const StepSolver& solver, const CornerBody& body,
                                   const Aligned<double>& r);

// stage.delta with A delta = r up to a residual of `target` (a norm).
Solved solve_linear(StepSolver& solver, Stage& stage, double target);

}  // namespace physics
