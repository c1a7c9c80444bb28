#pragma once

// Triangles that face out, also of a mesh that does not agree with itself.

#include "geometry/mesh/mesh_fwd.hpp"

#include <vector>

namespace geometry {

// The triangles of a mesh, some turned over. Those that are wound against the others of their
// piece, the ones with less area, and closed pieces that are wound inwards. A closed piece within
// another (nested_pieces.hpp) is turned if the smallest around it is, and not otherwise: it bounds
// a hollow or none, whether or not all of the model is mirrored. Nothing is turned across an edge
// of other than two triangles. `turned` counts them, `one_way` the edges where that cannot be (a
// Moebius strip).
struct WoundOut {
    std::vector<Triangle> triangles;
    std::size_t turned = 0, one_way = 0;
};
WoundOut wound_out(const TriMesh& mesh);

}  // namespace geometry
