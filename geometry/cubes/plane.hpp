#pragma once

// The elastic plane: a sheet of cells, each a cube of no thickness. Its two faces across the flat
// axis are one: corners a and a | 1 << axis of a cube are the same, so a plane of n cells has about
// n particles, and whatever reads cubes reads it too. `fill` is the sheet's thickness over the
// cells' edge, which gives it the right mass and stiffness.
//
// In the plane u and v are the other two axes: (z, y) across x, (x, z) across y, (x, y) across z.

#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/plane_picture.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// The axes u and v of a plane across `axis`.
std::array<int, 2> plane_axes(int axis);

// The axis along which all cubes are flat; -1 when one has thickness, or there are none.
int flat_axis(const Cubes& cubes);

// Throws std::invalid_argument for cubes of no thickness, naming who needs it: "bricks".
void need_thickness(const Cubes& cubes, const char* who);

// Where a plane lies: cell (i, j) fills origin + size * ((i .. i + 1) along u, (j .. j + 1) along
// v).
struct PlaneGrid {
    int axis = 1;
    double size = 0;  // m, edge of a cell
    Vec3 origin = Vec3::Zero();
};

// Cells of a rectangle, ni by nj from (0, 0), and of the ellipse in it. Throws
// std::invalid_argument for more than `most_cells`.
inline constexpr std::int64_t most_cells = 20'000'000;
using Cells2 = std::vector<std::array<int, 2>>;
Cells2 rectangle_cells(int ni, int nj);
Cells2 ellipse_cells(int ni, int nj);

// Cells of an ni wide picture, as high as keeps its pixels square: those whose mean is at least
// `threshold`. The picture's top is at the high end of v, or the low end (far away) across y.
Cells2 picture_cells(const PlanePicture& picture, int axis, int ni, double threshold);

// Cells whose middle a triangle covers, seen along the axis.
Cells2 footprint_cells(const TriMesh& mesh, const PlaneGrid& grid);

// The sheet on `cells`, in any order, of one matter. Throws std::invalid_argument when there are
// none, or a size or thickness is not above 0.
Cubes plane_cubes(const Cells2& cells, const PlaneGrid& grid, double thickness,
                  const Matter& matter = {});

// Two triangles a cell, facing along the flat axis, one vertex and one normal for each corner and
// in their order. Texture coordinates run 0..1 over the bounds. Of a sheet (sheet.hpp) it is
// sheet_mesh().
TriMesh plane_mesh(const Cubes& plane);

// Unit normals of a plane's corners at x (K): the mean of the cells' around each, by area, but for
// those that are `torn` (C, or empty); along the flat axis where cells have none. Of a sheet they
// are sheet_normals(). K.
std::vector<Vec3> plane_normals(const Cubes& plane, std::span<const Vec3> x,
                                std::span<const std::uint8_t> torn = {});

}  // namespace geometry
