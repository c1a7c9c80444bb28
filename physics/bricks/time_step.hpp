#pragma once

// Implicit time steps of any method that moves the corners of cubes.
//
// Every integrator is made of stages of implicit Euler (stage.hpp): from (x0, v0), the velocities w
// tau seconds later are those with
//   M (w - v0) = tau (f(x0 + tau w) + f_ext - D w),     x = x0 + tau w
//   implicit Euler       one of dt; x1 = x, v1 = w. Damps what it cannot resolve, never rings.
//   implicit midpoint    one of dt/2; x1 = 2x - x0, v1 = 2w - v0. Second order; damps nothing, so
//                        it conserves momentum and (with Newton to convergence) angular momentum;
//                        where it would gain energy, implicit Euler (step_energy.hpp).
//   sdirk2               two of (1 - 1/sqrt 2) dt (Alexander 1977). Second order, and damps only
//                        what it cannot resolve.
// A step in which something hits is one of implicit Euler, whatever is chosen (bounce.hpp).
//
//   advance_implicitly   a frame, unless all is at rest (sleep.hpp)
//     substeps           each halved, up to eight times, where it does not stay finite, and up to
//                        twice where parts that touch do not settle or gain energy; cut where
//                        something that bounces hits
//       integrator       one stage or two
//         step_newton    rounds of: linearise, solve, touch
//           step_solver    the linear equations of a round
//           step_descent   in place of rounds where the motion is violent

#include "physics/body/corner_body.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"
#include "physics/state/step_options.hpp"

namespace physics {

// The state `dt` seconds later. Throws std::invalid_argument when state or loads do not fit the
// body or are not finite; whatever else goes wrong is told in the report of a finite state.
State advance_implicitly(const CornerBody& body, Elasticity& elasticity, State state,
                         const Loads& loads, double dt, const StepOptions& options);

// The cubes at rest with their first corner positions moved by nothing: x = rest, v = 0.
State rest_state(const CornerBody& body);

}  // namespace physics
