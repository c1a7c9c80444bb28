#pragma once

// The surface f = isovalue as a triangle mesh.
//
// Dual marching cubes on a sparse grid: cells are kept only where bounds of f over blocks of 8^3
// cells leave room for the surface. Every sheet of surface in a cell gives one vertex, every grid
// edge that the surface crosses one quad of the four sheets around it, cut along its shorter
// diagonal. Vertices are then moved onto the surface by Newton's steps along the gradient, and take
// their normals from it.
//   Nielson. Dual marching cubes. IEEE Visualization 2004.
// The sheets of all 256 corner patterns are derived, not listed: on a face with four crossings the
// inside corners are cut off one by one, the face's curves are chained around the cell. Two cells
// that share such a face would be joined by it twice where in both of them one sheet holds both of
// its curves; in those patterns it is the only face of its kind, and there both cut off the outside
// corners in its place, which splits the sheets. So the mesh is a manifold, closed inside `domain`.
//   Wenger. Isosurfaces: geometry, topology, and algorithms. CRC Press 2013, 5.3 (manifold dual
//   contouring).
//
// OpenVDB's mesher, below, takes 1.8 times as long for as many triangles (64 balls, 676k of them in
// 256^3 cells, 2 threads, field included), the worst of them of shape 0.004 (4 sqrt(3) area / sum
// of squared edges) where these have 0.38. It can merge faces where the surface is flat.

#include "geometry/field.hpp"
#include "geometry/mesh.hpp"

#include <functional>

namespace geometry {

// What polygonize() asks of a field. Called from many threads at once. Solid where the value,
// isovalue taken off, is >= 0. Values must not depend on which other points are asked.
struct IsoField {
    Box domain;                                                // m, holds all of the surface
    std::function<Interval(const Box&)> bounds;                // over a box
    std::function<void(const FieldBlock&, BlockValues&)> ask;  // value and gradient, padded blocks
};

// `field` must outlive the result. The domain is where the field is not 0; a plane alone has none.
IsoField iso_field(const Field& field);

inline constexpr std::size_t unlimited = 0x7fffffff;  // triangles, as many as a mesh holds

// `cell`: edge of a grid cell, m; the grid's corners are whole multiples of it in the world, so
// that the mesh of a thing at rest does not flicker. The surface is cut open where it leaves the
// domain. Throws std::invalid_argument for a cell that is not positive or too small for the domain
// (2^20 cells along an edge) or that gives more than about `max_triangles`, while they are looked
// for.
TriMesh polygonize(const IsoField& field, double cell, std::size_t max_triangles = 20'000'000);

// The same by OpenVDB's mesher, its vertices moved onto the surface too. `adaptivity`, 0..1: how
// far faces merge where the surface is flat. Throws std::runtime_error too, where this program was
// built without OpenVDB.
//   Museth. VDB: high-resolution sparse volumes with dynamic topology. ACM TOG 32(3), 2013.
TriMesh polygonize_openvdb(const IsoField& field, double cell, double adaptivity,
                           std::size_t max_triangles = 20'000'000);

}  // namespace geometry
