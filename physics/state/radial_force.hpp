#pragma once

// A field that pushes away from a place, draws towards it, or swirls about an axis through it.

#include "physics/state/loads.hpp"

namespace physics {

// m/s^2 at a place of the world. With d from the force's position to there,
//   (outward d + swirl x d) / max(|d|, R / 10) (1 - |d|^2 / R^2)^2
// within its radius R, and 0 beyond: whatever the mass, as gravity is.
Vec3 radial_acceleration(const Force& radial, const Vec3& place);

}  // namespace physics
