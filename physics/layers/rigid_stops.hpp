#pragma once

// Where rigid layers touch each other: neither gives, so their samples must stay out of the other.
//
//     .------------.
//     |      i     |     Each skeleton of a rigid body is stopped at the sample that is nearest to
//     o---o----o---o     another rigid body, and at up to seven more (o) that are about as near and
//    =======j========    lie far from those taken, so that a face stands on its corners.

#include "physics/layers/contact_types.hpp"

namespace physics {

// Adds a stop for each such sample that is nearer to the other body than half the thickness of its
// skeleton; `penetration` has one entry a body.
void find_rigid_stops(std::span<const ContactBody> bodies, std::vector<LayerStop>& stops,
                      std::vector<double>& penetration);

}  // namespace physics
