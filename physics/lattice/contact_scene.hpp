#pragma once

// A step's view of what may touch a lattice body.

#include "physics/body/corner_body.hpp"
#include "physics/lattice/torn_skin.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <span>
#include <vector>

namespace physics {

// Who is in contact, and when.
struct ContactScene {
    const CornerBody& body;
    const State& state;
    const std::vector<double>& inverse_mass;  // 1/kg, by corner; 0 where it is pinned
    double dt;                                // s, the step
    std::span<const Ball> balls = {};
    const TornSkin* torn = nullptr;  // null: nothing is
};

}  // namespace physics
