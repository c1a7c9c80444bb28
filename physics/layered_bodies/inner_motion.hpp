#pragma once

// Skeletons of a still body that are drawn elsewhere than a frame of the film ago. As frames of
// their own they go there straight and at constant spin, so that they push and rub as if their
// frames had moved.
//
//      before          now, in the same frame
//      o----o    --->     o            each skeleton s: now = T_s before, rigid; a frame for s
//                          \           starts where T_s^-1 puts it and ends where it is told
//                           o

#include "physics/layered_bodies/layered.hpp"

namespace physics {

// What takes a skeleton from `before` to `now`, and by how much they differ besides, m.
struct InnerMotion {
    Transform by = Transform::Identity();
    double rest = 0;
};
InnerMotion inner_motion(const geometry::Skeleton& before, const geometry::Skeleton& now);

// Gives frames of their own to skeletons of still bodies that have moved inside their frames since
// `before`, dt seconds ago. What they changed of their shape or size besides is the part's
// `change`.
void split_moved_frames(const LayeredScene& before, double dt, LayeredScene& now);

// Puts skeletons that change their shape, and their samples, to where they are after that share of
// the frame. `told` has them at its end.
void change_shapes(const std::vector<LayeredPart>& told, double share, LayeredScene& now);

}  // namespace physics
