#pragma once

// The elastic sheet of any mesh: a cell for each triangle, its corners the vertices. A cell is a
// cube of no thickness across z, whose side between corners 2 and 3 has shrunk to a point:
//
//      c  2, 3, 6, 7       What interpolates between the corners of a cube does so between those of
//      |\                  the triangle: with s and t in the cube, 0..1,
//      | \                   x = (1 - t) ((1 - s) a + s b) + t c
//      a--b                `fill` is the sheet's thickness over the cubes' size, which is the mean
//    0, 4  1, 5            length of the triangles' sides.
//
// Whatever reads cubes by their corners reads a sheet too; Cubes::place says where these rest.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

struct SheetOfMesh {
    Cubes cubes;
    std::size_t left_out = 0;  // triangles without area, or of vertices not finite
    std::size_t doubled = 0;   // others left out: they are there twice, however they are wound
    std::size_t joints = 0;    // edges at which more than two triangles meet
};

// Cells in the order of the mesh's triangles and corners in that of its vertices; vertices at one
// place are one corner. Triangles are turned to face as wound_out.hpp has it. With a `longest` side
// (m) above 0, triangles are cut first, at the middles of sides that are longer; new corners come
// after the others. Throws std::invalid_argument for a thickness that is not above 0, and for a
// mesh without triangles that have an area.
SheetOfMesh make_sheet(const TriMesh& mesh, double thickness, const Matter& matter = {},
                       double longest = 0);

// Its three corners, counter-clockwise seen from the side that it faces.
inline std::array<std::uint32_t, 3> sheet_triangle(const Cubes& sheet, std::size_t cell)
{
    const auto& k = sheet.corners[cell];
    return {k[0], k[1], k[2]};
}

// Where in its cell, 0..1, a point of the triangle lies.
Vec3 place_in_cell(const Vec3& barycentric);

// Of a sheet's cell or a plane's: its area (m^2) and its middle (m), at rest.
double cell_area(const Cubes& cubes, std::size_t cell);
Vec3 cell_middle(const Cubes& cubes, std::size_t cell);

// Its triangles again, one vertex and one smooth normal for each corner.
TriMesh sheet_mesh(const Cubes& sheet);

// Unit normals of a sheet's corners at x (K, m): the mean of the triangles' around each, by their
// angles there; zero where they have none. K.
std::vector<Vec3> sheet_normals(const Cubes& sheet, std::span<const Vec3> x);

}  // namespace geometry
