#pragma once

// How stiff a partly filled cube is compared with a full one.

#include "geometry/cubes/cubes.hpp"

namespace physics {

// What share of a full cube's stiffness a partly filled one has.
enum class Weighting { filled, full };

// The factor on cube c's stiffness: 1, or its fill but at least 1/1000, so that a cube that a mesh
// only grazes still holds together.
double stiffness_share(const geometry::Cubes& cubes, std::size_t c, Weighting weighting);

}  // namespace physics
