#pragma once

// The closed parts of a mesh, a bone in flesh or boxes side by side, and which cubes lie in which.

#include "geometry/cells/inside.hpp"
#include "geometry/cells/voxel_grid.hpp"
#include "geometry/cubes/assign_matter.hpp"
#include "geometry/cubes/cubes.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace geometry {

// Triangles that hang together by corners in one place and have no border.
struct ClosedPart {
    std::vector<std::uint32_t> triangles;  // of the lattice mesh
    bool one_matter = true;                // all have the same
    double volume = 0;                     // enclosed, in cells
};

// Faces of one matter make a part where they are closed by themselves: boxes that touch are two
// parts if they are of two matters. Other faces make one with whatever hangs together with them.
// What has a border or encloses nothing is in no part. The largest part first.
std::vector<ClosedPart> find_closed_parts(const LatticeMesh& mesh, const FaceMatter& matter);

// The share of a cube that lies in a part and in no smaller one within it but hollows, the parts
// that look in by Inside::winding.
struct PartShare {
    std::uint32_t cube, part;
    double share;
};

// By 4 x 4 x 4 points of each cube marked in `cut`, and by the middle of the others; of a piece of
// several in a cell (Cubes::part), by those of them in its quarters. Points that the parts together
// leave outside (in a hollow of theirs, by `rule`) count for none. Sorted by cube and part. `parts`
// as they were found: the last that a point lies in has it, a hollow only where it is the only one.
std::vector<PartShare> part_shares(const LatticeMesh& mesh, std::span<const ClosedPart> parts,
                                   Inside rule, const Cubes& cubes,
                                   std::span<const std::uint8_t> cut);

}  // namespace geometry
