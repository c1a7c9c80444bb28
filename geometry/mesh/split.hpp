#pragma once

// One mesh as several.

#include "geometry/mesh/mesh.hpp"

#include <span>

namespace geometry {

// Some faces of a mesh, as a mesh of their own.
struct SplitMesh {
    // Without normals and texture coordinates; with the materials and groups in use.
    TriMesh mesh;
    std::vector<std::uint32_t> faces;  // F, of the whole, ascending
};

// A mesh for each of `count` numbers, of the faces f with of[f] equal to it, and of the vertices
// that they use, in their order. Faces with other numbers are left out.
std::vector<SplitMesh> split(const TriMesh& mesh, std::span<const std::uint32_t> of,
                             std::size_t count);

// The faces f of a mesh with kept[f] not 0 (F), in their order, with the vertices, normals, texture
// coordinates, polygons, materials and groups that they use.
TriMesh part_of(const TriMesh& mesh, std::span<const std::uint8_t> kept);

}  // namespace geometry
