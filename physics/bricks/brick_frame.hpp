#pragma once

// How a frame of bricks begins and ends, whatever else is stepped with them.

#include "physics/bricks/brick_elasticity.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"
#include "physics/state/step_options.hpp"

namespace physics {

// Throws std::invalid_argument for steps that a body with rigid parts cannot take.
void check_rigid(const StepOptions& options);

// Gives the elasticity the rotations and rest shapes of a state, and turns knots back.
void begin_frame(const BricksBody& body, const State& state, const Pins& pins,
                 const StepOptions& options, BrickElasticity& elasticity);

// Adds to a state what is known of its cubes, and warns of those that are inside out. Before the
// frame of dt seconds its largest speed was `before`, m/s.
void end_frame(const BricksBody& body, double before, double dt, const StepOptions& options,
               BrickElasticity& elasticity, State& state);

// Cube by cube what is kept lane by lane.
std::vector<float> by_cube(const BricksBody& body, const Aligned<float>& lanes);

}  // namespace physics
