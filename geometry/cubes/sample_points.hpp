#pragma once

// The points of a point cloud as samples.

#include "geometry/cubes/sample_surface.hpp"

namespace geometry {

// Every finite vertex of a mesh without faces, in its order, of one matter. They have no area: a
// cube that holds any is full of them, and all weigh the same. Throws std::invalid_argument when
// there are none, and for SampleMass::By::surface_density.
Samples sample_points(const TriMesh& cloud, const Matter& matter, const SampleMass& mass);

}  // namespace geometry
