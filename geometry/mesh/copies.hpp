#pragma once

// Many copies of one mesh, in rows, layers and columns.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// Rows along x, layers along y and columns along z of copies of one mesh.
struct CopiesLayout {
    std::array<int, 3> count{2, 1, 2};
    Vec3 step{1, 1, 1};          // m, from one copy to the next
    Vec3 stagger{0, 0, 0};       // m, by which every second layer is moved
    double hue_degrees = 0;      // by which a copy's colours are turned on from the one before
    bool number_groups = false;  // each copy's groups are its own: "leg" becomes "leg 1", "leg 2"
};

// All copies as one mesh, their middle where the mesh was; layers one after another, in each rows
// along x first. A hue that comes round again is the same material. Throws std::invalid_argument
// when a count is below 1, when there would be more than 2^32 - 1 vertices, or 65,536 materials or
// groups.
TriMesh copies(const TriMesh& mesh, const CopiesLayout& layout);

// A display colour (sRGB) of the same saturation and value, its hue turned; linear in and out.
Vec3f turn_hue(const Vec3f& colour, double degrees);

}  // namespace geometry
