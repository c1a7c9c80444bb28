#pragma once

// What Voxelize does where `stiffness` is calibrated: makes fine cubes of the mesh, and gives the
// cubes the stiffness that these have (physics/modal/calibrate.hpp).

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "graph/types/context.hpp"

#include <functional>

namespace nodes {

struct CalibrationParams {
    int fine = 0;  // fine cubes along the edge of a cube; 0: by the thinnest wall
    int modes = 12;
};

// `fine_of` makes cubes of a number along the edge of a cube. Warns where walls are so thin that
// the stiffness is wrong even so.
geometry::Cubes with_calibrated_stiffness(const geometry::TriMesh& mesh,
                                          const geometry::Cubes& cubes,
                                          const CalibrationParams& params,
                                          const std::function<geometry::Cubes(int)>& fine_of,
                                          const graph::Context& context);

}  // namespace nodes
