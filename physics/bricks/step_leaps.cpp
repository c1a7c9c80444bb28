#include "physics/bricks/step_leaps.hpp"

#include "physics/bricks/step_descent.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr int leaps_turned = 6;  // with K turned with the cubes, before all of the derivative
constexpr int most_leaps = 14;
constexpr double accuracy = 1e-4;  // of each linear solution

// The residual that is small enough at stage.w, with f and K there. Rounding is no reason not to
// take a first leap: what it hides in stiff bodies are loads that move them all the same.
double small_enough(const Stage& stage, const StepSolver& solver, double tolerance, int leaps)
{
    const double target = tolerance * forces_at_work(stage, solver);
    return leaps == 0 ? target : std::max(target, rounding_of(stage, solver));
}

}  // namespace

bool leap(Stage& stage, StepSolver& solver, double tolerance, StepRecord& record)
{
    const Aligned<double> start = stage.w;
    bool arrived = false, definite = true;
    stage.at_start = false;
    for (int i = 0; i <= most_leaps; ++i) {
        place(stage);
        stage.elasticity.use_hessian(i >= leaps_turned && definite);
        stage.linear_at.clear();
        linearise(stage, stage.x);
        find_residual(stage);
        prepare(solver, stage);
        const double size = norm(solver, stage.r);
        arrived = size <= small_enough(stage, solver, tolerance, i);
        if (arrived || !std::isfinite(size) || i == most_leaps) break;
        Solved solved = solve_linear(solver, stage, accuracy * size);
        record.report.iterations += solved.iterations;
        if (!solved.converged) {
            if (!stage.elasticity.uses_hessian()) break;
            definite = false;
            continue;
        }
        for (std::size_t k = 0; k < stage.frame.n; ++k) stage.w[k] += stage.delta[k];
    }
    stage.elasticity.use_hessian(false);
    stage.linear_at.clear();
    if (!arrived) stage.w = start;
    return arrived;
}

}  // namespace physics
