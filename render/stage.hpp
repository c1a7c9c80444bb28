#pragma once

// The stage of a shot: the box that the camera, the shadow and the floor are laid out for. It is
// taken from what stands still (the mesh or the cubes at rest), so that none of the three follows
// what moves.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/loads.hpp"
#include "render/scene.hpp"

#include <memory>
#include <optional>
#include <span>

namespace render {

// Whether a collider is a plane that lies level, which is drawn as the floor.
bool is_level_plane(const physics::Collider& collider);

// Height of the highest level plane among `colliders`, m.
std::optional<double>
solid_floor(std::span<const std::shared_ptr<const physics::Collider>> colliders);

// The bounds of `rest`, else of `cubes` at rest, else `drawn`, each where it is not null. The box
// reaches down to `floor` where that is less than three diagonals below: the model may fall onto
// it.
Box stage_of(const TriMesh* rest, const geometry::Cubes* cubes, const Box& drawn,
             const std::optional<double>& floor);

}  // namespace render
