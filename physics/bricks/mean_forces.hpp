#pragma once

// The forces that hold a body in a frame, in the mean over its steps: what a state tells of pins
// and of what is touched.
//
// Pins and colliders move evenly within a frame. What they speed up by, they do in its first step
// alone, whose forces are the higher the more steps the frame has, and those of the last step know
// nothing of it. The mean is what changes the momentum within the frame:
//   sum dt_i f_i / sum dt_i
// f_i is the force in the stage that a step solved: where that ended, which for the midpoint rule
// is half way. A step of two stages (sdirk2) has the mean of both, by their weights.
//
// What pins that turn push against each other turns with them in it (pin_paths.hpp).

#include "physics/bricks/stage.hpp"

#include <vector>

namespace physics {

struct MeanForces {
    std::vector<Vec3> reaction;      // N, of each pin
    std::vector<Vec3> held;          // H, N, of springs that hold the material
    std::vector<Grip> grips, holds;  // in_order(); point, other, corners and force alone
};

// The forces of pins in a stage: those on corners as the record has them, those of springs with
// corners at x.
MeanForces forces_of_pins(const Stage& stage, const StepRecord& record, const Aligned<double>& x);
// The same of a stage that was solved, and those of what it touches, with corners at stage.x.
MeanForces forces_of_stage(const Stage& stage, const StepRecord& record);
// Adds a share of some.
void add_share(MeanForces& mean, const MeanForces& some, double share);

// Tells a state the forces of pins.
void tell_pins(const MeanForces& mean, const Pins& pins, State& state);
// Grips as the last step left them, with the mean of forces, and those that let go within the
// frame.
std::vector<Grip> with_mean(std::vector<Grip> last, const std::vector<Grip>& mean);
// Those of them that still touch.
std::vector<Grip> without_those_gone(std::vector<Grip> grips);

}  // namespace physics
