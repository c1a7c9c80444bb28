#pragma once

// A stage as a search for a minimum. Its equations are those of the lowest point of
//   Phi(w) = 1/2 (w - v0)^T M (w - v0) + U(x0 + tau w) - tau f_ext . w + 1/2 tau w^T D w
// (Martin, Thomaszewski, Grinspun, Gross. Example-based elastic materials. SIGGRAPH 2011), which
// Newton steps with a line search go down, so that they can only lose energy. It serves where one
// linearisation would not do:
//   - more rounds of Newton's method were asked for. K is then all of the second derivative of U,
//     with which a bent body converges quadratically, as long as conjugate gradients find it
//     positive; where they do not, it is K turned with the cubes, which always is. (Made positive
//     cube by cube, it would be far too stiff in every slender body: Longva, Loeschner,
//     Fernandez-Fernandez, Larionov, Ascher, Bender. Pitfalls of projection: a study of Newton-type
//     solvers for incremental potentials. arXiv 2311.14526, 2023.)
//   - a stage would turn or stretch a cube by a large part of itself. There linear forces mean
//     nothing, and stiff parts on soft ones would be flung out.

#include "physics/bricks/step_solver.hpp"

namespace physics {

// Whether the linear forces were asked too much: a cube between neighbours in one stage.
bool is_violent(const Stage& stage);

struct Descent {
    int rounds = 30;
    double target = 0;     // norm of the residual that is small enough
    double tolerance = 0;  // ... or this share of the forces at work where w leads
    bool hessian = false;
};
enum class Descended { arrived, out_of_rounds, stuck };

// Goes down Phi from stage.w. Solves that fell short stand in the record.
Descended descend(Stage& stage, StepSolver& solver, const Descent& how, StepRecord& record);

// Contacts that come and go, stick and slip, and damping that turns with the cubes can make whole
// Newton steps go round in circles. The residual is (but for the lag of friction and of damping)
// minus the gradient of a function of w that is convex nearby: where it points back along the step
// stage.delta by more than half of how it pointed on at `from`, r . delta = `slope` there, the step
// went too far. It ends between, where the function is nearly lowest. stage.r is that of stage.w.
void draw_back(Stage& stage, const Aligned<double>& from, double slope);

// The norm that a residual is told as a share of: the largest of the forces from outside, those of
// elasticity and those of inertia where the stage ends. Where it starts does not count: a step that
// went wrong leaves forces there beside which the next one would look right. Where it ends they are
// large beside the residual only if they balance each other.
double forces_at_work(const Stage& stage, const StepSolver& solver);
// The norm of a residual that rounding of positions leaves at best: stiff bodies and joints under
// small loads do not come closer.
double rounding_of(const Stage& stage, const StepSolver& solver);

}  // namespace physics
