#pragma once

// The separate pieces of a mesh, and what is asked of each.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// Triangles that share a vertex belong to one piece.
struct Pieces {
    std::vector<std::uint32_t> of;     // F, the piece of each triangle, by order of first triangles
    std::vector<std::uint32_t> first;  // P, first triangle
    std::vector<double> area;          // P, m^2
    std::vector<double> volume;        // P, m^3, signed: negative when its faces look inward
    std::vector<std::uint8_t> encloses;  // P, whether it closes up: its area vectors add to nothing
    std::size_t count() const { return first.size(); }
};

// Whether the triangle's vertices are there and finite.
bool is_finite(const TriMesh& mesh, const Triangle& t);

// Triangles that are not finite have no_index.
Pieces find_pieces(const TriMesh& mesh);

// The first vertex of each vertex's piece, V: itself where no triangle uses it.
std::vector<std::uint32_t> first_vertices(const TriMesh& mesh);

}  // namespace geometry
