#pragma once

// A patch of elastic plane that carries the fine deformation of a part of a large object's surface:
// the closing idea of the elastic plane's paper. The object moves the patch's rim and the mesh;
// what the patch does beyond that, its particles' displacement from where the object alone would
// carry them, is added to the vertices that lie over it:
//   x = x_object + weight(height) (x_patch - x_carried)(u, v)
// The rim is pinned to the object, so the detail fades to nothing there.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// Which cell of the patch each vertex lies over, at rest.
struct PlaneDetail {
    struct Vertex {
        std::uint32_t vertex = 0;
        std::array<std::uint32_t, 4> corner{};
        std::array<float, 4> weight{};  // of detail; they sum to 1 at the patch, less away from it
    };
    std::vector<Vertex> vertices;
};

// Vertices nearer to the patch than `distance` (m) along its flat axis; the weight falls smoothly
// to 0 there. Throws std::invalid_argument when `patch` is not a plane, but a sheet or thick.
PlaneDetail bind_plane_detail(const TriMesh& rest, const Cubes& patch, double distance);

// `mesh` (as the object carries it) with the patch's detail: its corners are at x, and would be at
// `carried`. Normals are turned with the triangles. Throws std::invalid_argument when sizes differ.
TriMesh add_plane_detail(const PlaneDetail& binding, const TriMesh& mesh, const Cubes& patch,
                         std::span<const Vec3> x, std::span<const Vec3f> carried);

}  // namespace geometry
