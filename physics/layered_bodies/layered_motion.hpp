#pragma once

// How frames and cubes of a layered body go on in a step, once their velocities are known, and
// which velocities those have that are told where to be.

#include "physics/layered_bodies/layered.hpp"

#include <span>

namespace physics {

// Puts the frames where their cubes carry them.
void follow_cubes(const LayeredBody& body, LayeredState& state);

// Cubes whose corners go by `dv`, and the frames that they carry. Warns where neighbours part by
// more than a cube in one step: that is more than its linear forces know of.
void move_cubes(const LayeredBody& body, std::span<const Vec6> dv, double dt, LayeredState& state);

// Frames on their way for dt seconds.
void coast(const LayeredBody& body, double dt, LayeredState& state);

// The same after their velocities have changed by `dv`.
void move(const LayeredBody& body, std::span<const Vec6> dv, double dt, LayeredState& state);

// Rigid bodies keep the pose that they started at: their joints with the world are there, wherever
// later poses lead the frames that are held.
void keep_first_poses(const LayeredScene& scene, std::vector<LayeredPart>& told);

// Gives what is told where to be the velocity that it takes, `left` seconds before the frame's end:
// still and led frames go there straight, at constant spin, and so do pinned corners.
void drive_all(double left, LayeredScene& now);

// Puts meshes that change their shape to where they are after so many of the frame's steps, with
// where they were, or would have been, a step before. `told` has them at its end, `last` as the
// frame began.
void move_meshes(LayeredScene& now, const LayeredScene& last, const std::vector<LayeredPart>& told,
                 float step, int steps);

}  // namespace physics
