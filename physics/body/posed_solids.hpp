#pragma once

// Solids as sheets find them in a step: each solid part is a collider whose surface is where its
// cubes carry it. What a sheet touches of it is handed to the cube there, so that the solid is
// pushed by as much.

#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/body/collider_contact.hpp"

#include <memory>
#include <vector>

namespace physics {

// Their surfaces at both ends of a step, which posed colliders point into.
struct PosedSolids {
    std::vector<std::shared_ptr<geometry::TriMesh>> before, now;  // m
};

// Adds the solids of a body behind `colliders`, at x, where they came within dt seconds from
// `before` (by slot, four numbers each; null: they have not moved). Those that no sheet can touch
// have no surface. `room` must outlive the colliders.
void pose_solids(const CornerBody& body, const double* before, const double* x, double dt,
                 PosedSolids& room, std::vector<PosedCollider>& colliders);

// Hands what touches solids to their cubes: of each touch of the last colliders, the corners and
// weights of the place of the solid that it touches follow the sheet's.
void join_solids(const CornerBody& body, const double* x,
                 const std::vector<PosedCollider>& colliders, std::vector<PlaneTouch>& touches);

// Forgets of which side of each other a sheet and a solid were where they went through each other
// by more than a quarter of the solid, as in an impact that did not converge: kept, some points
// would stay on one side and some on the other.
void forget_tangles(const CornerBody& body, std::size_t colliders, std::vector<Grip>& grips);

}  // namespace physics
