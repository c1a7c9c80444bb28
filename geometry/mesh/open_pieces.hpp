#pragma once

// Pieces of a mesh that are open, and what they would hold if flat lids closed their holes: a bowl
// holds much, a sheet nothing.

#include "geometry/mesh/pieces.hpp"

#include <array>

namespace geometry {

struct OpenPiece {
    std::uint32_t piece = 0;  // into Pieces
    double lids = 0;          // m^2, of all its holes
    double volume = 0;        // m^3, with its lids on
    // Of its largest hole. m: the mean of its rim's edges, and the diameter of a circle as large.
    Vec3 centre = Vec3::Zero();
    double across = 0;
    std::array<Vec3, 8> half_way{};  // m, from the centre to the rim, around it
};

// Those with holes, in their order. The area of a lid is that of the vector sum_i c_i x c_{i+1} / 2
// over its rim c. Edges of faces that disagree on what is outside are no rim.
std::vector<OpenPiece> open_pieces(const TriMesh& mesh, const Pieces& pieces);

}  // namespace geometry
