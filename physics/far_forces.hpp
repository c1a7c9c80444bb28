#pragma once

#include "geometry/cubes.hpp"
#include "physics/loads.hpp"

#include <span>
#include <string>
#include <vector>

namespace physics {

// A sentence for each point force that has no material within its radius, and so acts on the
// nearest corner alone. A force is given some room: only what is farther off than its radius and
// the diagonal of a cube counts, as a mesh may stand out of its cubes. Forces of nothing are left
// out, and numbers too, so that a force that moves is told of once.
std::vector<std::string> far_forces(const geometry::Cubes& cubes, std::span<const Force> forces);

}  // namespace physics
