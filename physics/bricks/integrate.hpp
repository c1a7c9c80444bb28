#pragma once

// One step of a frame, by the integrator that was chosen (time_step.hpp).

#include "physics/bricks/impacts.hpp"
#include "physics/bricks/mean_forces.hpp"
#include "physics/bricks/stage.hpp"
#include "physics/bricks/step_energy.hpp"
#include "physics/bricks/step_solver.hpp"

namespace physics {

class HoldingElasticity;

// Where a frame has got to.
struct Motion {
    Aligned<double> x, v;  // m, m/s
};

// All that a frame's steps work with.
struct FrameStep {
    FrameStep(StepFrame& its_frame, Elasticity& elasticity)
        : frame(its_frame), stage(its_frame, elasticity), solver(stage)
    {}

    StepFrame& frame;
    const HoldingElasticity* holding = nullptr;  // the stage's, if springs hold some of the body
    Stage stage;
    StepSolver solver;
    StepRecord record;
    Motion now;
    // m, with rigid parts: the end of the stage as it was solved, before these turned.
    Aligned<double> solved;
    MeanForces forces;      // of the stage that was solved last, of the step once that is taken
    MeanForces mean;        // of the steps that were taken
    EnergyAccount account;  // of the midpoint rule
    Risen risen;            // of the last step that was not cut in halves
    Squashed squashed;      // since it hit, within the frame
    int halvings = 0;       // of the step that was taken last
    int finer = 0;          // halvings for the error's sake that the next step begins with
    // Where something hit that is followed while it is squashed: the error of the stage before the
    // others bounced, in edges of cubes.
    double solved_error = 0;
};

// Whether errors choose the length of steps.
bool are_by_error(const StepOptions& options);

// From share `begin` to share `end` of the frame. Velocities jump where something hits, and what
// methods of second order make of a jump throws it back faster than it came: such a step is one of
// implicit Euler.
void integrate(FrameStep& step, double begin, double end);

}  // namespace physics
