#pragma once

// What a frame says of itself: where steps are too long for what moves, regions too wide or too
// soft for the material, cubes turned inside out.

#include "physics/lattice/step_state.hpp"

namespace physics {

// How many cells the ends of a plane's links pass each other by in a substep, at most.
double cells_crossed(const FrameState& step);

// How many substeps the frame takes at least for the body to be as stiff as its material.
int least_substeps(const FrameState& step);
// ... and from which on nothing is left out of its stiffness to volume.
int substeps_for_volume(const FrameState& step);

// Fills state.report after the last step; `crossed` is what cells_crossed() said before the first.
void report_frame(FrameState& step, double crossed);

}  // namespace physics
