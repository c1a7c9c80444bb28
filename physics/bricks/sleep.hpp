#pragma once

// Bodies at rest sleep: a frame in which nothing would move is not stepped.
//
// What rests for `frames_at_rest` frames, whose rest shapes do not flow, and whose forces balance
// with all velocities 0, keeps its state for another frame. That takes one evaluation of the
// forces, which is also what wakes it: a load, a pin, a collider or a wind that changes leaves
// forces unbalanced. Nothing else is kept, so that a shot goes on from any of its states.
//
// Forces balance within twice the tolerance on each part. Rigid parts may be off by more where a
// step from rest would move them by less than `still`, and slow motion does not slow them further:
// contacts that stop them as a whole are so stiff that a millionth of a cube is a tenth of their
// weight.
//
// Either condition alone would stop what moves. Where a swing turns back, velocities are 0 for a
// moment; a thin tail may hang from so heavy a body that its weight is below the tolerance.

#include "physics/bricks/step_newton.hpp"

namespace physics {

// Frames in a row in which nothing moves by more than `still` before it sleeps.
inline constexpr int frames_at_rest = 12;
inline constexpr double still = 3e-5;       // cubes a frame of 1/24 s; in slow motion as slow
inline constexpr double still_rest = 1e-7;  // strain a frame, by which rest shapes may still flow

// Whether no corner moves by more than that on its way between two places (by slot, m) within so
// many seconds.
bool is_still(const CornerBody& body, const Aligned<double>& from, const Aligned<double>& to,
              double seconds);

// Whether the body at x and v (m and m/s, by slot) stays there for a frame when it is stopped: pins
// and colliders do not move, and what stops it balances the forces on each part to the tolerance.
// Where it does, the record's residual is what is left over. The stage is started.
bool stays_at_rest(Stage& stage, StepSolver& solver, const Aligned<double>& x,
                   const Aligned<double>& v, StepRecord& record);

}  // namespace physics
