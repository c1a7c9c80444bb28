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
// In place of OpenVDB's polygonizer: that wants the field as a narrow band of floats first, leaves
// vertices off the surface, and costs 13 s of compile time. For 256^3 cells it took 53 ms on 2
// threads beside the band (530k triangles); all of this, field included, takes 95 ms (676k
// triangles).

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

// `cell`: edge of a grid cell, m; the grid's corners are whole multiples of it in the world, so
// that the mesh of a thing at rest does not flicker. The surface is cut open where it leaves the
// domain. Throws std::invalid_argument for a cell that is not positive or too small for the domain
// (2^20 cells along an edge, 2^31 triangles).
TriMesh polygonize(const IsoField& field, double cell);

}  // namespace geometry
