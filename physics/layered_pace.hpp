#pragma once

// How many steps a frame of layered bodies wants.

#include "physics/layered.hpp"
#include "physics/layered_system.hpp"

namespace physics {

// As many equal steps as were asked for, or as it takes for what may touch a soft layer to come on
// by no more than two fifths of it in each: a skeleton's stop sees it coming on the inner half. Up
// to most_steps(asked); a body for which that is too few is warned of in its report. `dt`: s, of
// the frame.
int choose_steps(LayeredScene& now, const Vec3& gravity, double dt, int asked);

// 64 times as many, or as many as there can be.
int most_steps(int asked);

// How many steps in `dt` seconds it takes for held frames to swing, turn and slow down by no more
// than 0.3 rad, or 0.3 of their speed, in each. Explicit forces are stable up to 2; what a bounce
// loses or gains where steps change their length in it goes with the square: 2 % at 0.3, 6 at 0.5.
struct ExplicitPace {
    double steps = 0;
    std::size_t part = 0;  // whose frame wants them
};
ExplicitPace explicit_pace(const LayeredScene& now, const LayeredSystem& system, double dt);

}  // namespace physics
