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

// Of triangles with corners in the same three places, wound the same way and of one `kind` (of each
// triangle; empty: all alike), the first stays. Those wound against each other both stay, as
// between two boxes side by side, unless the whole of a piece is so and either side of it closes:
// it is one surface with two sides, and its first ones stay. Both sides of an open one stay, and
// enclose nothing. The rest is turned as wound_out.hpp has it. Triangles that name a vertex that is
// not there, or one that is not finite, are left out and not counted.
SolidFaces solid_faces(const TriMesh& mesh, std::span<const std::uint16_t> kind = {});

// The mesh with these faces and no normals or materials; without vertices that they do not use.
TriMesh mesh_of(const TriMesh& mesh, const SolidFaces& faces);

}  // namespace geometry
