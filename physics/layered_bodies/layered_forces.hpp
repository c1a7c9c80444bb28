#pragma once

// The forces that move layered bodies, with their stiffness and damping, for one step's system:
// contacts and stops, weight, air, springs, hinges, joints, and what particles do to each other.

#include "physics/layered_bodies/layered_bounce.hpp"

namespace physics {

// All of them but the elasticity of contacts that bounce: aim() adds what those give. Held frames
// get contacts, springs and the springs of hinges and joints: Bullet does the rest.
void add_forces(const LayeredScene& scene, const LayeredMoment& moment, const LayeredWorld& world,
                const Impacts& impacts, LayeredSystem& system);

// How weight brings the two bodies of a stop together, where they fall freely.
struct FallTogether {
    double rate = 0;    // m/s^2
    double behind = 0;  // m/s, that their velocities lack of it
};

// How much nearer to each other the two points of a stop may come in a step of dt seconds, m:
// skeletons stay out of other bodies, by a tenth of their thickness; one that stands nearer comes
// out by a fifth of what it lacks each step. Meshes that change their shape come on besides.
// What hits bounces as its matter says.
double stop_room(const LayeredMoment& moment, const LayerStop& stop, const FallTogether& fall,
                 double dt);

// Whether what hits there bounces off in the step.
bool bounces_off(const LayeredMoment& moment, const LayerStop& stop, const FallTogether& fall,
                 double dt);

// `lag`: s, of each body, see BounceTimes.
FallTogether falls_together(const LayeredScene& scene, const LayerStop& stop, const Vec3& gravity,
                            const std::vector<double>& lag);

}  // namespace physics
