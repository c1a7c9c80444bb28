#pragma once

// The part of drawing a mesh that does not depend on where its vertices are.

#include "geometry/mesh/mesh.hpp"

namespace render {

// How a mesh's faces become vertices to draw. OpenGL wants one index a corner, so a vertex is drawn
// as often as it has different normals or materials. All of this stays the same while the mesh
// moves: each frame only positions and normals are gathered through it.
struct SurfaceLayout {
    // Triangles that are drawn alike.
    struct Part {
        std::size_t count = 0;  // triangles
        bool clear = false;     // whether one sees through them
        bool textured = false;  // by the texture or normal map of `material`
        std::uint16_t material = 0;
    };

    std::shared_ptr<const geometry::MeshTopology> topology;  // of the meshes that it is for
    std::vector<std::uint32_t> position;                     // D, into TriMesh::positions
    std::vector<std::uint32_t> normal;                       // D, into TriMesh::normals
    std::vector<std::uint16_t> material;                     // D, into MeshTopology::materials
    std::vector<std::uint32_t> uv;  // D, into MeshTopology::uvs or no_index; empty without textures
    // Into the D: opaque faces, then those that one sees through. Wound so that the normals' side
    // is the front.
    std::vector<geometry::Triangle> triangles;
    std::vector<Part> parts;  // they have all triangles, in their order
    std::size_t skipped = 0;  // faces that name vertices, normals or materials that are not there

    bool suits(const geometry::TriMesh& mesh) const
    {
        return topology == mesh.topology && positions == mesh.positions.size() &&
               normals == mesh.normals.size();
    }
    std::size_t positions = 0, normals = 0;  // of the mesh that it was made from
};

// The layout for `mesh`, which must have normals, and for all others with its topology.
SurfaceLayout surface_layout(const geometry::TriMesh& mesh);

}  // namespace render
