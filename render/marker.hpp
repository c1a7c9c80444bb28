#pragma once

// Loads as things to draw.

#include "physics/loads.hpp"
#include "render/scene.hpp"

namespace render {

// An arrow from `from` to `to` with a head; `width` is the head's. Empty when it has no length.
TriMesh arrow(const Vec3& from, const Vec3& to, double width);

// Arrows for a force, sized for the stage: a wind blows in from the side it comes from, a point
// force presses on its place, gravity stands beside the stage. `weight` (N) is the force that gets
// an arrow of half the greatest length. Empty when the force is zero.
std::vector<TriMesh> force_arrows(const physics::Force& force, const Box& stage, double weight);

// The surface of a collider. A plane becomes a square as large as the stage. Null for a mesh
// collider without a mesh.
std::shared_ptr<const TriMesh> collider_surface(const physics::Collider& collider,
                                                const Box& stage);

}  // namespace render
