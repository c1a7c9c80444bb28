#pragma once

// The rounds of Newton's method that solve a stage. A stage is linearised where it starts and
// solved once (Baraff, Witkin. Large steps in cloth simulation. SIGGRAPH 1998); more rounds if
// asked. Contact is solved with it by a semismooth Newton iteration over the points that touch: a
// round for each time that those change. Where more than one round is asked for, a stage that
// touches nothing as it begins goes down by the whole second derivative first (step_descent.hpp),
// and is solved again as below where it then touches something.
//
//   linearise at x0 -> solve A delta = r -> w += delta --.-- violent? -> step_descent
//        ^                                               |
//        '-- r too large yet: touch, linearise again <---'

#include "physics/bricks/step_solver.hpp"

namespace physics {

// How often a step is cut in halves at most where what hits gains energy, or rigid parts turn far.
inline constexpr int most_halvings = 4;

// Solves a stage that has been started, from and to stage.w. What fell short stands in the record.
void solve_stage(Stage& stage, StepSolver& solver, StepRecord& record);

// r of a stage that has been started, with the forces at x0 and what is touched there.
void find_forces_at_start(Stage& stage);

// N, what each pin pushes with where stage.r is left over.
std::vector<Vec3> reactions_of(const Stage& stage);

// Evaluates what the equations of a solved stage leave over at the w it has now, and adds it to the
// record as a share of the forces at work. The next stage starts with the forces found here.
void find_leftover(Stage& stage, StepSolver& solver, StepRecord& record);

}  // namespace physics
