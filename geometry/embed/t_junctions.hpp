#pragma once

// Faces of a cut mesh that share an edge may have been cut in different places: one ends where a
// plane between parts crosses the edge, and another, of a cube that is whole there, does not. As
// the edge bends with its cubes, such a T-junction opens. So faces are split where others end on
// their edges.
//
//      +-------+-------+          +-------+-------+
//      |       |       |          |       |       |
//      +-------o-------+    ->    +-------o-------+     o  an end of two faces above, and then of
//       \             /            \      |      /         those below as well
//         \         /                \    |    /
//           \     /                    \  |  /
//             \ /                        \|/

#include "geometry/cubes/cubes.hpp"
#include "geometry/embed/cut_faces.hpp"

namespace geometry {

// Numbers the places of the corners of `cut`. Splits its faces, and faces of the mesh beside them,
// which are then among those of `cut`.
void split_at_t_junctions(const TriMesh& rest, const Cubes& cubes, CutFaces& cut);

}  // namespace geometry
