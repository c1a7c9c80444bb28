#pragma once

// Force fields on layered bodies: gravity, wind, point and radial forces.
//
//   gravity  m a on every frame, or corner of the cubes below
//   wind     on each sample of the surface, of area A and normal n, with u = wind - v there:
//              1/4 rho drag A |n . u| u
//            a quarter, because a closed surface meets the wind before and behind: a ball gets
//            1/2 rho drag pi r^2 |u| u
//   point    the total shared by the samples within the radius, as drawn, by area and distance;
//            the nearest one gets it where there are none
//   radial   m a on every particle or corner, by its place; on a rigid frame force and torque as on
//            a box of its mass and its inertia
// Bodies that are told where to be feel none.

#include "physics/layered_bodies/layered_system.hpp"

#include <span>
#include <string>
#include <vector>

namespace physics {

// m/s^2: how all that is free falls: the world's gravity and that of its fields.
Vec3 free_fall(const LayeredWorld& world);

// A warning for each point force with no surface within its radius and the spacing of samples, nor
// around it, as bodies are drawn: all of it acts on the nearest sample. Zero forces are left out.
// The text holds no numbers but the force's own, so that a moving force is told of once.
std::vector<std::string> far_point_forces(std::span<const LayeredPart> parts,
                                          std::span<const Force> forces);

// All but radial ones.
void add_fields(const LayeredScene& scene, const LayeredMoment& moment,
                std::span<const Force> forces, LayeredSystem& system);

// Radial ones. `further`, m: of each frame and corner, how much further on than it is it takes
// them; empty: where it is.
void add_radial_fields(const LayeredScene& scene, const LayeredMoment& moment,
                       std::span<const Force> forces, std::span<const Vec3> further,
                       LayeredSystem& system);

}  // namespace physics
