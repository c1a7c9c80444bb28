#pragma once

// A factor of the matrix of a stage's linear equations (direct_factor.hpp) as a preconditioner: one
// that is fresh leaves a few iterations, which put right its rounding and contacts between parts.
// It is kept for the rounds that follow, and made anew once it saves less than it costs.

#include "physics/bricks/direct_factor.hpp"
#include "physics/bricks/stage.hpp"

#include <limits>
#include <optional>

namespace physics {

struct StepDirect {
    // What it takes, in products with K; infinity where the method or the body has no factor.
    double work = std::numeric_limits<double>::infinity();
    double work_an_iteration = 1;
    // Iterations that another way took for each factor e, when it fell short in this frame; 0: none
    // did.
    double others_took = 0;

    std::shared_ptr<const Dissection> tree = nullptr;
    std::optional<DirectFactor> factor = std::nullopt;
    double tau = 0;        // s, of the stage that the factor was made in
    bool hessian = false;  // of the factor
    std::vector<BrickMatrix> cubes = {};
    Aligned<double> diagonal = {};

    // Tells the work.
    void count(const Stage& stage);
    // Whether the factor may serve for the stage.
    bool serves(const Stage& stage) const;
    // Makes the factor of A as its elasticity is coupled, with `diagonal` and contacts. False: A is
    // not positive.
    bool make(const Stage& stage, const Aligned<double>& lumped);
};

}  // namespace physics
