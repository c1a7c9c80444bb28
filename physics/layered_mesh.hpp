#pragma once

// The surfaces of a layered scene as one mesh.

#include "physics/layered.hpp"

namespace physics {

struct LayeredMeshOptions {
    enum class Surface : std::uint8_t { exact, seeds };
    Surface surface = Surface::exact;  // polygonized afresh, or the seeds' own preview
    double cell = 0.02;                // m, of the grid that exact surfaces are found on
    int body = -1;                     // which one; -1: all
    bool deformed = true;              // as contacts leave it; false: as if nothing touched
    enum class Cut : std::uint8_t { none, x, y, z };
    Cut cut = Cut::none;  // leaves out what lies beyond `cut_at` along this axis, open
    double cut_at = 0;    // m
};

// Each body that emits seeds is a group and a material in its part's colour; attribute
// "compression": how far each vertex is pressed, in units of the field. Normals are the gradient's.
geometry::TriMesh layered_mesh(const LayeredScene& scene, const LayeredMeshOptions& options);

}  // namespace physics
