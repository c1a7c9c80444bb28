#pragma once

// The grid that a field's surface is meshed on: cells in blocks of 8^3, of which only those matter
// that the surface may pass. Its corners are whole multiples of the cell in the world.

#include "geometry/fields/iso_field.hpp"

#include <span>
#include <vector>

namespace geometry {

inline constexpr int block_cells = 8;

struct IsoGrid {
    const IsoField& field;
    double cell;
    Vec3i lo, hi;  // cells, half open; none when the domain is empty
    std::size_t max_triangles;

    Vec3 point(const Vec3i& i) const { return cell * i.cast<double>(); }
};

// Throws std::invalid_argument for a cell that is not positive or too small for the domain (2^20
// cells along an edge).
IsoGrid iso_grid(const IsoField& field, double cell, std::size_t max_triangles);

// Thrown where a mesh would be larger than allowed; polygonize.hpp makes a message of it.
struct TooManyTriangles {};

// In order of z, then y, then x.
bool block_before(const Vec3i& a, const Vec3i& b);

// Blocks that the surface may pass, by bounds of the field while the domain is halved; ascending.
// Throws TooManyTriangles as soon as they are so many that the mesh must be too large.
std::vector<Vec3i> crossed_blocks(const IsoGrid& grid);

// Moves vertices onto the surface along its gradient, each within the box of edge `width` whose
// lowest corner is `low`, and takes their normals from the gradient.
void onto_surface(const IsoField& field, std::span<Vec3> vertices, std::span<const Vec3> low,
                  double width, std::span<Vec3f> positions, std::span<Vec3f> normals);

}  // namespace geometry
