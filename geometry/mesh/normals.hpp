#pragma once

// Normals of a mesh, and the corners around its vertices that they are computed from.

#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// Twice the area vector of every triangle: (b - a) x (c - a), along the outward normal. F, m^2.
std::vector<Vec3> area_vectors(const TriMesh& mesh);

// Gives `mesh` new normals: at each corner of a face the mean, weighted by the angle at the vertex,
// of those faces around it whose own normals lie within `crease` radians of the face's. 0 gives
// flat faces, pi smooth ones. Faces without area take no part, and borrow what their vertices have.
// Thuermer, Wuethrich. Computing vertex normals from polygonal facets. JGT 3(1), 1998 (weights).
void compute_normals(TriMesh& mesh, double crease);

// A fan of corners that share a vertex: which (face, corner) pairs lie around each vertex.
struct VertexCorners {
    std::vector<std::uint32_t> begin;   // V + 1, into corner
    std::vector<std::uint32_t> corner;  // 3F, 3 * face + which of its corners

    std::span<const std::uint32_t> around(std::size_t vertex) const
    {
        return {corner.data() + begin[vertex], corner.data() + begin[vertex + 1]};
    }
};
VertexCorners vertex_corners(const TriMesh& mesh);

}  // namespace geometry
