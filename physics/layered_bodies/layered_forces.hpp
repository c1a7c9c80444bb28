#pragma once

// The forces that move layered bodies, with their stiffness and damping, for one step's system:
// contacts and stops, weight, air, springs, hinges, joints, and what particles do to each other.

#include "physics/layered_bodies/layered_system.hpp"

namespace physics {

// All of them. Held frames get contacts, springs and the springs of hinges and joints: Bullet does
// the rest.
void add_forces(const LayeredScene& scene, const LayeredMoment& moment, const LayeredWorld& world,
                LayeredSystem& system);

// How much nearer to each other the two points of a stop may come in a step of dt seconds, m:
// skeletons stay out of other bodies, by a tenth of their thickness; one that stands nearer comes
// out by a fifth of what it lacks each step. Meshes that change their shape come on besides.
double stop_room(const LayeredMoment& moment, const LayerStop& stop, double dt);

}  // namespace physics
