#pragma once

// What of a body lies in each quarter of each cell, and across which faces of the quarters it goes
// on: the neighbourhood that tells apart pieces which one cell holds.
//
// A triangle is convex, and so are two neighbouring quarters together: where it meets both, it
// crosses what they have in common. The inside of a solid crosses a face either all over, or up to
// triangles that cross the face as well. So two quarters are linked where
//     one triangle meets both,
//     or one of them is all inside,
//     or the middle of their face is inside.
// Two pieces are linked only where they meet one quarter. A gap wider than a quarter keeps pieces
// along the axes apart, one of sqrt(3) quarters keeps any two apart.

#include "geometry/cells/cell_set.hpp"
#include "geometry/cells/inside.hpp"
#include "geometry/cells/sub_cells.hpp"
#include "geometry/cells/voxel_grid.hpp"

namespace geometry {

struct HeldCells {
    using Links = std::array<SubCells, steps.size()>;

    std::vector<Vec3i> cells;             // C, sorted by (z, y, x)
    std::vector<SubCells> held;           // C, quarters that hold material; never none
    std::vector<std::uint32_t> links_of;  // C, into links; no_index: a cell all inside, each of
                                          // whose quarters is linked across all of its faces
    // Of each step, the quarters that are linked with the one it leads to, in this cell or the
    // next. Links of quarters that hold nothing do not count.
    std::vector<Links> links;
};

// A mesh in lattice coordinates, with those snapped to quarters as grid.lattice() snaps to cells.
LatticeMesh snapped_to_quarters(LatticeMesh mesh, const VoxelGrid& grid);

// Of `cells`, sorted, what triangles pass (CellShape::half_open).
HeldCells held_by_surface(const LatticeMesh& mesh, std::vector<Vec3i> cells);

// Of `cells`, sorted, what a solid fills: quarters whose inside a triangle crosses, and those whose
// centre is inside. A triangle in a face between quarters adds the upper one where neither is held
// otherwise.
HeldCells held_by_solid(const LatticeMesh& mesh, Inside rule, std::vector<Vec3i> cells);

}  // namespace geometry
