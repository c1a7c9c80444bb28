#pragma once

// How much of a cell is inside, for the cells that the surface of a mesh passes through.

#include "geometry/cells/solid_cells.hpp"

namespace geometry {

// The cells that faces pass through, sorted by (z, y, x), and how much of each is inside.
struct InsideShares {
    std::vector<Vec3i> cells;
    std::vector<double> share;  // 0 to 1
};

// The area of a face in a cell; in cells, more than 0.
struct FaceInCell {
    Vec3i cell;
    std::uint32_t triangle;
    double area;
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
// `faces`, unless null, is filled with what each face has in each cell, of all cells, in the order
// of the faces: the same cut gives both.
InsideShares inside_shares(const LatticeMesh& mesh, Inside rule,
                           std::vector<FaceInCell>* faces = nullptr);

}  // namespace geometry
