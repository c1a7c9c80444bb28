#pragma once

// Wind on a mesh that vibrates in modes: the drag of the air on each triangle, by its velocity
// relative to the air.

#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/state/loads.hpp"

#include <span>
#include <vector>

namespace physics {

// k modes of a mesh with V vertices, and how it moves.
struct MovingModes {
    const geometry::TriMesh& rest;
    std::span<const std::vector<geometry::Vec3f>> shape;  // k x V, kg^-1/2
    std::span<const double> q_dot;                        // k, sqrt(kg) m/s
    const geometry::Vec3& base_velocity;                  // m/s
};

// What winds do to each mode, from the triangles at rest. Each triangle of area A and normal n, of
// a mesh with two sides or of a sheet, takes
//   F = 1/4 rho C A |n . u| u,   u = wind - v
// as add_wind() (physics/body/external_forces.hpp) does it.
struct ModalWind {
    std::vector<double> load;  // k, N kg^-1/2
    double rate = 0;  // 1/s: the drag's derivative by the modes' velocities has no larger one
};
ModalWind wind_on_modes(const MovingModes& modes, std::span<const Force> forces);

}  // namespace physics
