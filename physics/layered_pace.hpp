#pragma once

// How many steps a frame of layered bodies wants.

#include "physics/layered.hpp"

namespace physics {

// As many equal steps as were asked for, or as it takes for what may touch a soft layer to come on
// by no more than two fifths of it in each: a skeleton's stop sees it coming on the inner half. Up
// to 64 times as many; a body for which that is too few is warned of in its report. `dt`: s, of the
// frame.
int choose_steps(LayeredScene& now, const Vec3& gravity, double dt, int asked);

}  // namespace physics
