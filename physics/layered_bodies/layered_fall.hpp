#pragma once

// Free fall in the steps of the implicit solver.
//
// Backward Euler moves what falls by h (v + h a) in a step of h seconds: h^2 a / 2 more than a
// parabola. What nothing holds is moved back by that. It ends where the parabola does, with the
// velocity that it has there. Frames that touch each other, or that joints and springs link, fall
// as one.
//
// Contacts that bounce push explicitly (layered_bounce.hpp), which keeps energy where velocities
// are those of the middles between two places:
//
//     places       o-----o-----o        A body that bounces gets its weight late: its velocities
//     lag velocities      ^-----^           by half of its last step, and it is not moved back.
//
// In a step it gets the weight of  h + (lag before - lag after) / 2  seconds.

#include "physics/layered_bodies/layered_bounce.hpp"

namespace physics {

// Of each body, whether its velocities lag after a step of dt seconds: it bounces, and nothing
// bears its weight.
std::vector<char> will_lag(const LayeredScene& scene, const LayeredMoment& moment,
                           const Impacts& impacts, const Vec3& gravity, double dt);

// Adds the weight that bodies have to get for earlier steps, less what they will get later.
void add_lag(const LayeredScene& scene, const std::vector<char>& lags, const Vec3& gravity,
             LayeredSystem& system);

// m: how far the group of each frame and corner has come in the middle of a step, where radial
// forces are taken (bricks/radial_on_way.hpp): of a system that has all others. 0 for what is held,
// touches what is held, or lags, which are moved from where they start. No frame goes by itself:
// torques are about places where the step starts.
std::vector<Vec3> half_ways(const LayeredScene& scene, const std::vector<char>& lags,
                            const Vec3& gravity, const LayeredSystem& system);

// m: by how much each frame and corner is moved back after a step that changes velocities by `dv`.
// 0 for what is held, touches what is held, or lags. The more of its velocity the air takes in the
// step, the less it is, and nothing from a fourth on (free_fall.hpp).
std::vector<Vec3> lifts(const LayeredScene& scene, const std::vector<char>& lags,
                        const Vec3& gravity, const LayeredSystem& system,
                        const std::vector<Vec6>& dv);

}  // namespace physics
