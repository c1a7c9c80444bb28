#pragma once

// Closed pieces of a mesh that lie within others: a hollow in a solid, a bone in flesh.

#include "geometry/mesh/pieces.hpp"

#include <span>

namespace geometry {

class TriangleBvh;

// Whether vertices, up to 256 of them, are all inside of a closed mesh; false of none.
bool holds(const TriangleBvh& outer, std::span<const Vec3f> vertices);

struct NestedPiece {
    std::uint32_t piece = 0, around = 0;  // into Pieces; around: the smallest that it lies in
    int depth = 0;                        // how many it lies in
    int winding = 0;  // how often those wind around it: 1 in a solid, 0 in its hollow
};

// Pieces that close up and lie wholly in others that do, by their boxes and up to 256 vertices.
std::vector<NestedPiece> nested_pieces(const TriMesh& mesh, const Pieces& pieces);

// Whether it is wound as what is around it, so that a test by winding finds no hollow.
bool is_wound_as_around(const Pieces& pieces, const NestedPiece& nested);

// Turns nested pieces over until a test by winding finds what one by parity finds of them: those
// in an odd number of others look in, the rest looks out.
void wind_by_parity(TriMesh& mesh);

}  // namespace geometry
