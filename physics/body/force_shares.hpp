#pragma once

// What each corner takes of a force or torque that is spread around a point.

#include "physics/body/corner_body.hpp"
#include "physics/state/loads.hpp"

#include <utility>
#include <vector>

namespace physics {

// Slot and share; the shares' sum is 1. A slot may stand several times.
using ForceShares = std::vector<std::pair<std::uint32_t, double>>;

// By position and radius of the force, as add_steady_forces() says (external_forces.hpp).
ForceShares force_shares(const CornerBody& body, const Force& force);

}  // namespace physics
