#pragma once

// What of a mesh lies before a plane across an axis, open where it is cut.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// The mesh where p[axis] <= at (m): triangles that reach beyond are cut there, without gaps between
// them. Positions, triangles, and normals where each vertex has one; nothing else.
TriMesh clipped(const TriMesh& mesh, int axis, float at);

}  // namespace geometry
