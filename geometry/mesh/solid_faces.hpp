#pragma once

// The faces of a mesh that bound a solid, as a test of what is inside needs them: each once, and
// turned out.

#include "geometry/mesh/mesh_fwd.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace geometry {

struct SolidFaces {
    std::vector<Triangle> triangles;    // T, of the first of the mesh's vertices in each place
    std::vector<std::uint32_t> source;  // T, the number of each in the mesh, ascending
    std::size_t doubled = 0;            // left out, as they lie on others
    std::size_t turned = 0;             // turned over
};

// Of triangles with corners in the same three places, wound the same way, the first stays. Those
// wound against each other both stay, as between two boxes side by side, unless the whole of a
// piece is so: it is one surface with two sides, and its first ones stay. The rest is turned as
// wound_out.hpp has it. Triangles that name a vertex that is not there, or one that is not finite,
// are left out and not counted.
SolidFaces solid_faces(const TriMesh& mesh);

}  // namespace geometry
