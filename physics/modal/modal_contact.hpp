#pragma once

// A mesh that vibrates in modes, stopped by colliders: impulses on its vertices, in modal
// coordinates.
//
// A step of h seconds starts with impulses p_i >= 0 along the colliders' normals n_i, after which
// each mode swings exactly as without colliders. At its end no vertex is inside:
//   g_i = gap_i + n_i . sum_k phi_k(i) a_k sum_j (phi_k(j) . n_j) p_j >= 0,   p_i g_i = 0
// with a_k the displacement of mode k after h seconds by a unit of velocity. It is solved by
// projected Gauss-Seidel: the matrix is symmetric and, as omega_k h <= 1, not negative. A vertex
// comes on to the collider and does not leave it by the impulse, so that impacts take energy and
// make none; what throws the body back is its own elasticity. (Moreau. Unilateral contact and dry
// friction in finite freedom dynamics. 1988, with gaps at the end of a step.)
//
// What is left out: friction and `bounce` of the colliders, and faces between vertices. Places are
// linear in the modes: what turns far swells. A vertex that begins inside a collider leaves it
// within a step, and is fast then.

#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/state/loads.hpp"

#include <span>
#include <vector>

namespace physics {

// k modes of a mesh with V vertices.
struct StoppedModes {
    const geometry::TriMesh& rest;
    std::span<const std::vector<geometry::Vec3f>> shape;  // k x V, kg^-1/2
    std::span<const double> omega_sq;                     // k, rad^2/s^2
    std::span<const double> damping;                      // k, 1/s
};

// A part of a frame on colliders.
struct ModalContactStep {
    std::span<const Collider> colliders;
    double frame = 0;              // s, of which the colliders' motion is told
    double end = 1;                // share of it gone by when the step ends
    Vec3 base{0, 0, 0};            // m, at its end
    Vec3 way{0, 0, 0};             // m, that the base moves in the step
    std::span<const double> load;  // k, N kg^-1/2
    double h = 0;                  // s
    bool first = false;            // the frame is the first of a shot
};

// Steps q (sqrt(kg) m) and q_dot (sqrt(kg) m/s). Returns the deepest that a vertex is left inside a
// collider, m, by what one round of linear gaps misses.
double step_on_colliders(const StoppedModes& modes, const ModalContactStep& step,
                         std::span<double> q, std::span<double> q_dot);

// In how many steps to take `dt` seconds. Throws std::invalid_argument where they are too many.
int contact_steps(std::span<const double> omega_sq, double dt);

}  // namespace physics
