#pragma once

// What of a body touches colliders: points of its surface, what of its solids lies on edges and
// corners of colliders between these (feature_touches.hpp), and of its sheets (sheet_edges.hpp).

#include "physics/body/collider_contact.hpp"
#include "physics/body/plane_touch.hpp"

#include <vector>

namespace physics {

// The planes of all points that come to x at v (four numbers a slot) within dt seconds and are then
// in a collider, or before it by less than known_before cubes; in_order(). The last colliders of a
// body with solids beside sheets are those solids, posed, which sheets alone touch. `held` are the
// holds of the state that the step starts with. A plane at which a point arrives fast is so much
// stiffer that the point goes a tenth of a cube deep.
std::vector<PlaneTouch> find_collider_touches(const CornerBody& body, const double* x,
                                              const double* v,
                                              const std::vector<PosedCollider>& colliders,
                                              const std::vector<Grip>& held, double dt);

}  // namespace physics
