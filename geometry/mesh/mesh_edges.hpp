#pragma once

// The edges of a mesh: which triangles meet at each, and whether the mesh is closed.

#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// One side of one triangle as a use of the edge between vertices a < b.
struct EdgeUse {
    std::uint32_t a = 0, b = 0;
    std::uint32_t triangle = 0;
    std::uint8_t side = 0;  // the side from corner `side` to corner (side + 1) % 3
    bool forward = false;   // the triangle runs it from a to b
};

// The sides of all triangles, sorted by (a, b, triangle): uses of one edge stand side by side.
// Left out: triangles that name a vertex twice or one that is not there.
std::vector<EdgeUse> edge_uses(std::span<const Triangle> triangles, std::size_t vertex_count);

// Whether the triangles have no border as an oriented chain: every edge is run as often in one
// direction as in the other. Then the winding number of every point is a whole number, whatever
// the mesh does otherwise (several pieces, pieces that intersect, faces named twice).
bool is_closed(std::span<const Triangle> triangles, std::size_t vertex_count);

// The rims of holes, each as its vertices in the order in which the triangles beside it run them. A
// rim is followed round the triangles at each vertex: two holes that touch at a vertex are one, and
// the rims of two triangles that do are two. Where two triangles run an edge the same way it
// belongs to a rim.
std::vector<std::vector<std::uint32_t>> border_loops(std::span<const Triangle> triangles,
                                                     std::size_t vertex_count);

// How many edges more than two triangles share.
std::size_t crowded_edges(std::span<const Triangle> triangles, std::size_t vertex_count);

// How many edges of just two triangles both run the same way: one faces out, the other one in.
std::size_t disagreeing_edges(std::span<const Triangle> triangles, std::size_t vertex_count);

}  // namespace geometry
