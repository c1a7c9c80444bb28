#pragma once

// How fast the matter of a body goes at a point: with its frames, or as a mesh that changes its
// shape does.

#include "physics/layers/contact_types.hpp"

namespace physics {

// Of the mesh's nearest point. 0 where no time has passed.
Vec3 velocity_at(const MovingMesh& mesh, const Vec3& p);

// In the territory of that skeleton.
Vec3 velocity_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p);

}  // namespace physics
