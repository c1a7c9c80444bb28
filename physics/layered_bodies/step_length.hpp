#pragma once

// How many equal steps a frame of the film is cut into.
//
//     o )  -->  ( |      Two bodies that approach by more than a layer in one step would tunnel. A
//        layer           skeleton's stop sees what comes on in the inner half of its layer, so a
//                        step may bring it nearer by two fifths of the layer at most.

#include "physics/layered_bodies/layered_system.hpp"

namespace physics {

// As many steps as were asked for, or as it takes for whatever may touch a soft layer to approach
// by no more than two fifths of it per step; at most most_steps(asked). Where that is too few the
// body's report warns. `dt`: s, of the frame.
int choose_steps(LayeredScene& now, const Vec3& gravity, double dt, int asked);

// Whether two bodies that may touch within `dt` seconds approach each other faster than `speed`.
bool comes_on(LayeredScene& now, double dt, double speed);

// 64 times as many, or as many as there can be.
int most_steps(int asked);

// How many steps in `dt` seconds explicit forces need: held frames then swing and turn by no more
// than 0.3 rad per step, and slow down by no more than 0.3 of their speed. Explicit forces are
// stable up to 2; what a bounce loses or gains where steps change their length in it goes with the
// square: 2 % at 0.3, 6 at 0.5.
struct ExplicitSteps {
    double steps = 0;
    std::size_t part = 0;  // whose frame needs them
};
ExplicitSteps explicit_steps(const LayeredScene& now, const LayeredSystem& system, double dt);

}  // namespace physics
