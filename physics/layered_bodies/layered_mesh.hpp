#pragma once

// The surfaces of a layered scene as one mesh.

#include "physics/layered_bodies/layered.hpp"

namespace physics {

struct LayeredMeshOptions {
    enum class Surface : std::uint8_t { exact, samples };
    // Polygonized afresh, or from the samples as they stood at the last step, a substep ago: quick,
    // for previews; its normals are the faces', and pieces meet unjoined.
    Surface surface = Surface::exact;
    double cell = 0.02;    // m, of the grid that exact surfaces are found on
    int body = -1;         // which one; -1: all
    bool deformed = true;  // as contacts leave it; false: as if nothing touched
    enum class Cut : std::uint8_t { none, x, y, z };
    Cut cut = Cut::none;  // leaves out what lies beyond `cut_at` along this axis, open
    double cut_at = 0;    // m
    std::size_t max_triangles = 20'000'000;  // of a body's exact surface
};

// The second kind needs no field once the scene has made a step, and `deformed` always holds.
// Each body that emits samples is a group and a material in its part's colour; attribute
// "compression": how far each vertex is pressed, in units of the field. Normals are the gradient's.
geometry::TriMesh layered_mesh(const LayeredScene& scene, const LayeredMeshOptions& options);

}  // namespace physics
