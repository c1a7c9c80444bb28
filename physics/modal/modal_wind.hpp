#pragma once

// Wind on a mesh that vibrates in modes: the drag of the air on each triangle, by its velocity
// relative to the air.

#include "physics/modal/vibrate.hpp"

namespace physics {

// What winds do to each mode, from the triangles at rest with the velocities of the state (the
// base's included). Each triangle of area A and normal n, of a mesh with two sides or of a sheet,
// takes
//   F = 1/4 rho C A |n . u| u,   u = wind - v
// as add_wind() (physics/body/external_forces.hpp) does it.
struct ModalWind {
    std::vector<double> load;  // k, N kg^-1/2
    double rate = 0;  // 1/s: the drag's derivative by the modes' velocities has no larger one
};
ModalWind wind_on_modes(const ModalModel& model, const ModalState& state, const Vec3& base_velocity,
                        std::span<const Force> forces);

}  // namespace physics
