#pragma once

// A closed mesh made ready for distances.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

namespace geometry {

// Stored as its mesh alone.
struct SkeletonMesh {
    using Source = TriMesh;
    SkeletonMesh() = default;
    explicit SkeletonMesh(TriMesh m) : mesh(std::move(m)), tree(mesh) {}
    const Source& source() const { return mesh; }
    TriMesh mesh;
    TriangleBvh tree;
};

}  // namespace geometry
