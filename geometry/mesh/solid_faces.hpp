#pragma once

// The faces of a mesh that bound a solid, as a test of what is inside needs them: each once, and
// turned out.

#include "geometry/mesh/mesh_fwd.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace geometry {

struct SolidFaces {
    std::vector<Triangle> triangles;    // T, of the first of the mesh's vertices in each place
    std::vector<std::uint32_t> source;  // T, the number of each in the mesh, ascending
    std::size_t doubled = 0;            // left out, as they lie on others
    std::size_t turned = 0;             // turned over
};

// Of faces that are there twice and of one `kind` (of each triangle; empty: all alike) those stay
// that adds_to_solid() of doubled_faces.hpp names. The rest is turned as wound_out.hpp has it.
// Triangles that name a vertex that is not there, or one that is not finite, are left out and not
// counted.
SolidFaces solid_faces(const TriMesh& mesh, std::span<const std::uint16_t> kind = {});

// The mesh with these faces and no normals or materials; without vertices that they do not use.
TriMesh mesh_of(const TriMesh& mesh, const SolidFaces& faces);

}  // namespace geometry
