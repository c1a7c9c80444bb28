#pragma once

// Whole Newton steps for a stage that ends far from where it starts, as the search for an
// equilibrium does: no step is shortened.
//
// A linear step that turns a slender body also stretches it, by a share that grows with the square
// of the turn, and stretching is stiffer than bending by the square of the slenderness. Steps that
// only go down (step_descent.hpp) are therefore short: a bar of 1,000 cubes takes hundreds. Here
// the stretched shape is taken as it is, since its cubes have turned the right way. The next step
// is linear about their rotations, with K turned with the cubes, which knows nothing of the forces
// of the stretch, and takes it back. (Why Newton's method fails where those forces enter, and how
// others keep them out: Magisano, Leonetti, Garcea. How to improve efficiency and robustness of the
// Newton method in geometrically non-linear structural problem discretized via displacement-based
// finite elements. Comput. Methods Appl. Mech. Eng. 313, 2017.) A few steps with all of the second
// derivative end it.

#include "physics/bricks/step_solver.hpp"

namespace physics {

// Goes on from stage.w until the residual is `tolerance` of the forces at work. False, with stage.w
// as it was, where that is not reached. Nothing may touch.
bool leap(Stage& stage, StepSolver& solver, double tolerance, StepRecord& record);

}  // namespace physics
