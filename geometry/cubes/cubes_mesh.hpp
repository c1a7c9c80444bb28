#pragma once

// Cubes as a mesh that other programs can read and move: a vertex for every corner.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// Vertex i is corner i, at x[i]; inner corners are vertices of no face. Two triangles on each side
// that a cube shares with no other, facing outwards; of a sheet its triangles. Attributes at each
// corner are the means over its cubes: density (kg/m^3, of the material), young (Pa), poisson,
// fill, and the cubes' own. Throws std::invalid_argument when there are not as many positions as
// corners.
TriMesh cubes_mesh(const Cubes& cubes, std::span<const Vec3> x);

}  // namespace geometry
