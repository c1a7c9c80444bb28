#pragma once

// Rigid balls beside the bodies: where they start, what makes them invalid, and their mesh.

#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <span>

namespace physics {

// Where balls start.
std::vector<BallState> place_balls(std::span<const Ball> balls);

// Throws std::invalid_argument for a radius or mass that is not above 0, or what is not finite.
void check_balls(std::span<const Ball> balls);

// All balls as one mesh, in their order: two materials in turn, by sixths of each, so that one
// sees them roll. Throws std::invalid_argument when the state is of other balls.
geometry::TriMesh ball_mesh(std::span<const Ball> balls, std::span<const BallState> states,
                            int segments, const geometry::Vec3f& colour,
                            const geometry::Vec3f& second);

}  // namespace physics
