#pragma once

// Numbers of a state: speed, energies, momenta, centre of mass and inertia, forces of pins.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

namespace physics {

// Speed of the fastest corner; not a number if any velocity is not. m/s.
double largest_speed(const State& state);

// 1/2 v^T M v over the corners of `cubes`, with the mass that the state says they have. J. Throws
// std::invalid_argument when state and cubes have different numbers of corners.
double kinetic_energy(const State& state, const geometry::Cubes& cubes);

// Of the same mass. Throws as kinetic_energy() does.
struct MassMoments {
    double mass = 0;                                  // kg
    Vec3 centre = Vec3::Zero();                       // m
    Vec3 momentum = Vec3::Zero();                     // kg m/s
    Vec3 angular = Vec3::Zero();                      // kg m^2/s, about the centre
    geometry::Mat3 inertia = geometry::Mat3::Zero();  // kg m^2, about the centre
};
MassMoments mass_moments(const State& state, const geometry::Cubes& cubes);

// The forces of springs that hold points of the material, on each of the matter's corners (H, N),
// where these are `off` from their targets (H, m).
std::vector<Vec3> forces_of(const HeldMatter& matter, const std::vector<Vec3>& off);

// What pins exert on the body, in the mean over the last frame: of all, or of the corners `of`
// along the axes that these hold and of the points of the material that they hold.
struct PinForce {
    Vec3 force = Vec3::Zero();   // N
    Vec3 torque = Vec3::Zero();  // N m, about `point`
    std::size_t pins = 0;
};
PinForce pin_force(const State& state, const Pins* of, const Vec3& point);

// What held a body where it touched something, in the mean over the last frame, pushes and
// friction: by all of it, or less. Impacts that bounce do not count.
struct ContactOf {
    const StateModel* body = nullptr;     // null: all of the state
    const StateModel* another = nullptr;  // null: colliders and all bodies; else this body alone
    int collider = 0;                     // its number, from 1: this collider alone; 0: all
};
Vec3 contact_force(const State& state, const ContactOf& of);  // N, on the body

}  // namespace physics
