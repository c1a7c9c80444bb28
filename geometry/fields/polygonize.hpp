#pragma once

// The surface f = isovalue as a triangle mesh: dual marching cubes on a sparse grid.
//
// Cells are kept only where bounds of f over blocks of 8^3 cells leave room for the surface
// (iso_grid.hpp). Then, in a cut through the grid:
//
//   +-----+-----+-----+
//   |     |  .o-+---o-      o: every sheet of surface in a cell gives one vertex; around every grid
//   |     | / |     |          edge that the surface crosses, four sheets give one quad (here two
//   +-----+/--+-----+          give a line), cut along its shorter diagonal
//   |    o|   |     |       Vertices are then moved onto the surface by Newton's steps along the
//   |    ||   |     |       gradient, and take their normals from it.
//   +----++---+-----+
//
// The mesh is a manifold, closed inside `domain`: cell_patterns.hpp says how.
//   Nielson. Dual marching cubes. IEEE Visualization 2004.

#include "geometry/fields/iso_field.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <stdexcept>

namespace geometry {

inline constexpr std::size_t unlimited = 0x7fffffff;  // triangles, as many as a mesh holds

// `cell`: edge of a grid cell, m; the grid's corners are whole multiples of it in the world, so
// that the mesh of a thing at rest does not flicker. The surface is cut open where it leaves the
// domain. Throws std::invalid_argument for a cell that is not positive or too small for the domain
// (2^20 cells along an edge) or that gives more than about `max_triangles`, while they are looked
// for.
TriMesh polygonize(const IsoField& field, double cell, std::size_t max_triangles = 20'000'000);

// What to say where a mesh would be larger than allowed: from a coarser one it names cells that
// fit.
std::invalid_argument too_many_triangles(const IsoField& field, double cell,
                                         std::size_t max_triangles);

}  // namespace geometry
