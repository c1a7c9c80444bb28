#pragma once

// How fast the matter of a body goes at a point: with its frames, and as what changes its shape
// does.

#include "physics/layers/contact_types.hpp"

namespace physics {

// Of the mesh's nearest point. 0 where no time has passed.
Vec3 velocity_at(const MovingMesh& mesh, const Vec3& p);

// How far the place of a skeleton that is nearest to p goes while the skeleton goes from `before`
// to `after`; `now`: as it is between the two. All in its frame. Places keep their shares of
// lengths: the middle of a segment stays its middle. Exact for points, polylines, triangles,
// boxes, tori, cylinders and cones; along the chords of a curve, and about the middle of
// ellipsoids.
Vec3 way_of(const geometry::Skeleton& now, const geometry::Skeleton& before,
            const geometry::Skeleton& after, const Vec3& p);

// Shares of one to three points at the point of what they span that is nearest to p: themselves, a
// segment or a triangle.
Vec3 shares_at(const std::vector<Vec3>& points, const Vec3& p);

// Of the body's skeleton by its change of shape alone; 0 where it keeps its shape.
Vec3 change_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p);

// In the territory of that skeleton.
Vec3 velocity_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p);

}  // namespace physics
