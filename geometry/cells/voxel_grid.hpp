#pragma once

// The lattice that a model is cut up by, and models in its coordinates: lengths in cubes, cell c
// between c and c + 1.

#include "geometry/mesh/mesh_fwd.hpp"
#include "geometry/mesh/solid_faces.hpp"

#include <optional>
#include <span>
#include <string>

namespace geometry {

struct VoxelGrid {
    double size = 1;  // m, edge of a cube
    Vec3 origin = Vec3::Zero();
    Vec3i cells = Vec3i::Zero();  // along each axis; 0: no bounds

    // p in lattice coordinates. Which side of a cube's face a point is on should not hang on
    // rounding, so a coordinate within a millionth of a whole number, or within the spacing of
    // single-precision numbers, is taken to be that number. In a bounded grid the last cube holds
    // its upper face too: a box of ten cubes' length is ten cubes long.
    Vec3 lattice(const Vec3f& p) const;
};

// Three digits of a length, for messages.
std::string short_number(double value);

// The smallest box that holds every finite point.
Box finite_bounds(std::span<const Vec3f> points);

// The smallest box that holds every vertex with finite coordinates of a triangle.
Box triangle_bounds(const TriMesh& mesh);

// A grid of cubes of `size` that covers `box`, whatever is left over shared by its two sides.
// Throws std::invalid_argument when the box is empty, or more than 2^20 - 1 cubes long.
VoxelGrid fit_grid(const Box& box, double size);

// The size that puts `resolution` cubes along the longest side of `box`.
double size_for(const Box& box, int resolution);

// A mesh in lattice coordinates. Triangles that name a vertex that is not there, or one that is
// not finite, are left out.
struct LatticeMesh {
    std::vector<Vec3> positions;  // V
    std::vector<Triangle> triangles;
    std::vector<std::uint32_t>
        source;  // each one's number in the mesh; empty when none is left out

    std::optional<bool> closed;  // as is_closed() has it, where somebody has asked

    std::uint32_t source_of(std::size_t t) const
    {
        return source.empty() ? static_cast<std::uint32_t>(t) : source[t];
    }
};

// Throws std::invalid_argument when a triangle lies further than 2^20 - 1 cubes from the origin.
LatticeMesh to_lattice(const TriMesh& mesh, const VoxelGrid& grid);
// The same of these faces of it, and whether they are closed.
LatticeMesh to_lattice(const TriMesh& mesh, const SolidFaces& faces, const VoxelGrid& grid);

// Whether its triangles have no border (geometry/mesh/mesh_edges.hpp).
bool is_closed(const LatticeMesh& mesh);

// The cell that holds a lattice position: each point has one, a face belongs to the cube above it.
inline Vec3i cell_of(const Vec3& lattice)
{
    return lattice.array().floor().cast<int>();
}

}  // namespace geometry
