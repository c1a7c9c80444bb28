#pragma once

// Several meshes as one.

#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// One mesh that holds all of `meshes`, vertices and faces in their order. Equal materials and equal
// group names become one. What only some of them have is filled in for the others: smooth normals,
// vertex colours of their materials, attributes of 0, the default material. A point cloud adds its
// points. Throws std::invalid_argument when there are more than 2^32 - 1 vertices, or more than
// 65,536 materials or groups.
TriMesh merge(std::span<const TriMesh* const> meshes);

}  // namespace geometry
