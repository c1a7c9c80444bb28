#pragma once

// Forces where the material that they act on is now, for their arrows: their places are those of
// the rest shape.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/loads.hpp"

#include <optional>
#include <vector>

namespace render {

// Points that a body carries, m.
struct CarriedPoints {
    std::vector<geometry::Vec3> rest, now;  // as many
};

// How what is near a place of the rest shape has moved since: the place goes with the nearest
// point, and turns by the mean rotation of the points within `radius`, or of the nearest four where
// fewer are. A line of points does not turn. Precondition: there are points.
geometry::Transform motion_at(const CarriedPoints& points, const geometry::Vec3& place,
                              double radius);

// The same of the corners of cubes, where the place goes with the nearest place in a cube. Nothing
// where `only_near` and that is farther off than `radius` and the diagonal of a cube: then it is
// hardly this body that the force acts on. Precondition: there are cubes.
std::optional<geometry::Transform> motion_at(const geometry::Cubes& cubes,
                                             const CarriedPoints& corners,
                                             const geometry::Vec3& place, double radius,
                                             bool only_near);

// Moved to where its place is now; turned with it where the force follows.
physics::Force carried(physics::Force force, const geometry::Transform& motion);

}  // namespace render
