#pragma once

// Loads as things to draw: balls on pinned corners, arrows for forces, the surfaces of colliders.
// And the body without them: its ghost.

#include "physics/state/loads.hpp"
#include "render/scene.hpp"

#include <optional>

namespace render {

// An arrow from `from` to `to` with a head; `width` is the head's. Empty when it has no length.
TriMesh arrow(const Vec3& from, const Vec3& to, double width);

// Arrows for a force, sized for the stage: a wind blows in from the side it comes from, a point
// force presses on its place, gravity stands beside the stage; a torque has two heads, along its
// axis from its place on. `weight` (N), or at half of the stage's diagonal (N m), is what gets an
// arrow of half the greatest length; none is shorter than a quarter of that. Empty when the force
// is zero.
std::vector<TriMesh> force_arrows(const physics::Force& force, const Box& stage, double weight);

// How strong the force is, beside the tip of its arrow, or of the middle one of several. Nothing
// for a force without arrows.
std::optional<Note> force_note(const physics::Force& force, const Box& stage, double weight);

// The surface of a collider. A plane becomes a square as large as the stage. Null for a mesh
// collider without a mesh.
std::shared_ptr<const TriMesh> collider_surface(const physics::Collider& collider,
                                                const Box& stage);

// The three as parts of a scene, in the colours that tell them apart.
Balls pin_marks(const physics::Pins& pins, double radius);
std::vector<Surface> force_marks(const physics::Force& force, const Box& stage, double weight);
std::optional<Surface> collider_mark(const physics::Collider& collider, const Box& stage);

// A mesh as a pale shell of that opacity, around bodies; it casts no shadow.
Surface ghost(std::shared_ptr<const TriMesh> mesh, float opacity);

}  // namespace render
