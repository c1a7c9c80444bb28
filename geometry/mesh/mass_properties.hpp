#pragma once

// Volume, centre and inertia of what a closed mesh encloses.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// Of a body of density 1 kg/m^3: `mass` is then the volume in m^3.
struct MassProperties {
    double mass = 0;
    Vec3 centre = Vec3::Zero();   // m
    Mat3 inertia = Mat3::Zero();  // kg m^2, about the centre
};

// Exact, for a closed mesh wound outwards; where it overlaps itself, volume counts as often.
MassProperties mass_properties(const TriMesh& mesh);

}  // namespace geometry
