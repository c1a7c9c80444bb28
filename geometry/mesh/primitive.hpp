#pragma once

// Simple shapes, closed and wound outwards unless said otherwise, centred on the origin, with
// normals and texture coordinates where a shape has natural ones. All throw std::invalid_argument
// when a size is not positive and finite, or when a count would give more than 50 million faces.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// A box of `size` (m) cut into `divisions` pieces along x, y and z: 4 faces a square, two triangles
// each, and a hard edge all round. Texture coordinates run 0..1 on each side.
TriMesh box(const Vec3& size, const Vec3i& divisions);

// A sphere of `segments` >= 3 around y and `rings` >= 2 from pole to pole, vertices on the sphere.
TriMesh uv_sphere(double radius, int segments, int rings);

// A sphere of 20 * 4^subdivisions triangles of nearly equal size: a subdivided icosahedron.
TriMesh icosphere(double radius, int subdivisions);

// An open flat sheet in the plane y = 0, facing up: `size_x` by `size_z` (m).
TriMesh grid(double size_x, double size_z, int divisions_x, int divisions_z);

// A cylinder along y with `segments` >= 3 around, `rings` >= 1 along, and caps.
TriMesh cylinder(double radius, double height, int segments, int rings);

// A ring about y: `radius` from the centre to the middle of the tube, `tube` the tube's radius.
TriMesh torus(double radius, double tube, int segments, int tube_segments);

}  // namespace geometry
