#pragma once

// What lies on each cube of a model: points and bits of area of its surface, before they are packed
// into a ContactSurface (contact_surface.hpp).

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <array>
#include <vector>

namespace physics {

using geometry::Vec3f;

// What falls into one cube while the surface is gathered.
struct PatchPoint {
    Vec3f place;  // 0..1 in the cube, for strays outside
    std::array<float, 8> weight;
    float area;                    // m^2
    Vec3f normal = Vec3f::Zero();  // m^2, out of the surface, sum of its areas' normals
};
struct LoosePatch {
    std::vector<PatchPoint> points, within;
    std::vector<Vec3f> areas;
    std::vector<std::array<Vec3f, 3>> pieces;  // of the areas, as in ContactSurface
};

// C. The vertices and triangles of a mesh, with points a cube apart on triangles that are wider.
std::vector<LoosePatch> patches_of_surface(const geometry::Cubes& cubes,
                                           const geometry::TriMesh& mesh);

// C. The faces that no other cube covers, and their corners, each in one of its cubes. A plane has
// its two sides only, which share their corners.
std::vector<LoosePatch> patches_of_cubes(const geometry::Cubes& cubes);

// C. The two sides of the triangles of a sheet, and their corners.
std::vector<LoosePatch> patches_of_sheet(const geometry::Cubes& cubes);

// Adds corners that no point goes with, each in one of its cubes.
void add_corners_within(const geometry::Cubes& cubes, std::vector<LoosePatch>& patches);

}  // namespace physics
