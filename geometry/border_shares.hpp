#pragma once

#include "geometry/solid_cells.hpp"

namespace geometry {

// The cells that faces pass through, sorted by (z, y, x), and how much of each is inside.
struct BorderShares {
    std::vector<Vec3i> cells;
    std::vector<double> share;  // 0 to 1
};

// Exact but for rounding where the faces around a cell bound its inside without a doubt: the rows
// of cells that it lies in meet a closed surface, in which pieces do not overlap. Elsewhere (by
// holes, overlaps, faces named several times, neighbours that disagree on what is outside) it is
// the share of 4 x 4 x 4 points that `rule` says are inside, which a wall thinner than a quarter of
// a cell may slip through.
//
// The volume left of a face whose normal has a part along u is, by the divergence theorem in one
// dimension, a column that ends there; in cell c of a row along u
//
//   V_c = int_{faces in c} (u - u_c) dA_u + int_{faces of the row beyond c} dA_u
//
// with dA_u the faces' area as seen along u, positive where they face along it, and lengths in
// cells.
BorderShares border_shares(const LatticeMesh& mesh, Inside rule);

}  // namespace geometry
