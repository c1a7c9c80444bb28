#pragma once

// What the midpoint rule makes of springs that hold points of the material (holding_elasticity.hpp)
// and that its steps cannot resolve. Their points arrive where they are to be, and go on past the
// velocity of their targets by as much as they came from it:
//   v1 - t' = -(v0 - t')
// for ever, as nothing damps them. Corners that pins hold have the velocity of their targets
// (time_step.cpp); the corners of cubes whose points turn round within a step so get it by
//   (M + dt^2 A) u = dt^2 A (t' - v1)
// as implicit Euler's rule would bring them to it. A vibration that steps resolve turns round twice
// a period, where it is slowest, and loses next to nothing.

#include "physics/bricks/integrate.hpp"

namespace physics {

// After a step from share `begin` to share `end` of the frame, from velocities v0: step.now.v
// changes by u, the forces of springs by what gives u, and the energy due by what it takes.
void stop_ringing(FrameStep& step, const HoldingElasticity& holding, const Aligned<double>& v0,
                  double begin, double end);

}  // namespace physics
