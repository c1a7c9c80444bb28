#pragma once

// Gravity, point forces and wind on a body of cubes, as forces on its corners.

#include "geometry/cubes/cubes.hpp"
#include "physics/body/corner_body.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state_models.hpp"

#include <span>
#include <string>
#include <vector>

namespace physics {

// Adds the gravity of one frame to f (N, numbers), and point forces that do not follow the body
// (for those, see following_forces.hpp). A point force presses on the surface within its radius in
// the rest shape, by area times (1 - (distance / radius)^2)^2. It is integrated over the surface
// itself and handed to the corners with the weights of the embedding, so that force and torque stay
// what they are however large the cubes. Where no surface is so near, it pulls at the material
// within its radius, by mass; and where there is none either, at the one point. Its total is always
// `force`.
void add_steady_forces(const CornerBody& body, std::span<const Force> forces, Aligned<double>& f);

// Adds the drag of all winds on the surface at x, v, as f - drag v: f (N) and drag (N s/m),
// numbers. A bit of area A with normal n, turned and stretched with its cube, feels
//   1/2 rho C A |n . u| u / 2,   u = wind - v
// the last half because each side of a closed body is counted, the one behind too.
void add_wind(const CornerBody& body, std::span<const Force> forces, const double* x,
              const double* v, Aligned<double>& f, Aligned<double>& drag);

// Adds m a (N) of all radial forces, a of the place of each corner.
void add_radial(const CornerBody& body, std::span<const Force> forces, const double* x,
                Aligned<double>& f);

// Whether it is one of those two.
bool varies_by_place(const Force& force);

// Throws std::invalid_argument when a number of a force is not finite or below 0 where it may not.
void check_forces(std::span<const Force> forces);

// A warning for each point force or torque that has no material of any model within its radius, and
// so acts on the nearest corner alone. Only what is farther off than its radius and the diagonal of
// a cube counts, as a mesh may stand out of its cubes. Zero forces are left out. The text holds no
// numbers but the force's own, so that a moving force is told of once.
std::vector<std::string> far_forces(ModelsOfState models, std::span<const Force> forces);

}  // namespace physics
