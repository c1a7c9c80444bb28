#pragma once

// Solves the system of a step of layered bodies: the change of velocity of every frame and corner.

#include "physics/layered_bodies/layered_system.hpp"
#include "physics/state/state.hpp"

#include <optional>
#include <set>
#include <utility>

namespace physics {

// The least of  dv^T A dv / 2 - dv . right + sum stiffness min(0, u + room)^2 / 2  over stops,
// convex and quadratic in pieces. Newton's method: those that would be passed are held, the others
// let go, until that is what comes out; a step that does not go down is halved. Adds to the
// report's iterations, and says where it did not converge.
std::vector<Vec6> solve(LayeredSystem& system, Report& report);

// Layers that are pressed down to their skeletons in all steps of a frame: what arrived was faster
// than they can stop, or is heavier than they can bear.
class SpentLayers {
public:
    // After a step, which left `held` of its stops as they are.
    void take(const LayeredSystem& system);
    // At the end of the frame: a warning of each body.
    void tell(std::vector<LayeredState>& states) const;

private:
    std::optional<std::set<std::pair<std::uint32_t, std::uint32_t>>> bodies_;  // and what presses
};

}  // namespace physics
