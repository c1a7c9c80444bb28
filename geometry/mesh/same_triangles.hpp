#pragma once

// Whether two meshes are one that moves. The frames of a file are read apart: they have topologies
// of their own, which are equal all the same.

#include "geometry/mesh/mesh.hpp"

namespace geometry {

// Whether both join as many vertices by the same triangles.
inline bool same_triangles(const TriMesh& a, const TriMesh& b)
{
    return a.positions.size() == b.positions.size() &&
           (a.topology == b.topology || a.topology->triangles == b.topology->triangles);
}

// Whether `now` is `before` with vertices elsewhere. Null: it is not.
inline bool has_moved(const TriMesh* before, const TriMesh& now)
{
    return before && before != &now && same_triangles(*before, now) &&
           before->positions != now.positions;
}

}  // namespace geometry
