#pragma once

// Faces on one border, cut into triangles alike. A quad and its back are listed in opposite orders,
// so that programs often cut the one along the other diagonal than the other.

#include "geometry/mesh/mesh_fwd.hpp"

#include <span>
#include <vector>

namespace geometry {

// Of polygons with one border, whichever way each is wound, the later ones are cut as the first is;
// so are two triangles that make a flat, convex quad. Polygons that enclose a solid between them
// stay as they are. `triangles`: into `positions`, with one
// number for each place. `polygon`: as MeshTopology has it. No triangle that stands for a face
// alone changes, and none turns over.
void cut_alike(std::span<Triangle> triangles, std::span<const std::uint32_t> polygon,
               std::span<const Vec3f> positions);

}  // namespace geometry
