#pragma once

// The masses of rigid parts as their meshes have them, however coarse their cubes are.

#include "physics/body/corner_body.hpp"

namespace physics {

// Gives the corners of each rigid part the masses with which it has the centre and the inertia of
// what its shape encloses, and the mass of its cubes: of all such, those nearest to what they were.
// A part keeps its masses where its cubes differ in density, and where its shape holds less than
// 0.8 or more than 1.25 times their volume (a mesh that is not closed, or a hollow one). Where its
// corners cannot have the inertia (one cube has eight), the part gets the centre alone.
enum class MassOf {
    corners,
    bricks
};  // what of it lies between corners is bricks' (cube_mass.hpp)
void weigh_rigid_parts(const BodyModels& models, MassOf mass_of, CornerBody& body);

}  // namespace physics
