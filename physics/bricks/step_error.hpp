#pragma once

// How far a step of implicit Euler is off, told from the step itself.
//
// The step puts a corner at x0 + dt v1. The trapezoidal rule, of second order, puts it at
// x0 + dt (v0 + v1) / 2. Their difference, dt |v1 - v0| / 2, is the first term of the step's error
// (Hairer, Norsett, Wanner. Solving Ordinary Differential Equations I. 1993, II.4). What gravity
// adds to it, the step takes out itself (free_fall.hpp). Parts that nothing holds move as rigid
// bodies exactly (free_parts.hpp): of these the change of their shape alone counts, as it is seen
// from them. Rigid parts turn exactly: of those that something touches the changes of velocity and
// spin count.
//
// Radial forces vary along the way. A part that falls freely goes by their acceleration am in the
// middle of it (radial_on_way.hpp), dt^2 am / 2; by Simpson's rule it is dt^2 (a0 + 2 am) / 6, with
// a0 where the step begins. The difference is dt^2 (a0 - am) / 6.

#include "physics/bricks/stage.hpp"

namespace physics {

// The largest error of a corner, in edges of its cubes, of a step of dt seconds from (x0, v0) to
// (x1, v1) that the stage took.
double error_of_step(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0,
                     const Aligned<double>& x1, const Aligned<double>& v1, double dt);

// The most halvings of a frame that the error asks for: 32 steps.
inline constexpr int finest_by_error = 5;

// How often a frame is halved before its first step, where the one before took so many steps: once
// less than that, if all of them stood.
int halvings_of(int steps);

// Whether a step of twice the length may stay within `most` after one with this error: the error
// grows with the square of the length where the motion is smooth.
inline bool may_lengthen(double error, double most)
{
    return 4 * error < most;
}

}  // namespace physics
