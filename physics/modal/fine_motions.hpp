#pragma once

// How a free body moves most easily: its lowest modes, and its displacements under body forces
// that are linear in position.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/state.hpp"

#include <Eigen/Core>

namespace physics {

struct FineMotions {
    Eigen::MatrixXd of;          // 3 K x m: displacements of the corners
    std::vector<double> energy;  // m, twice: u^T K u, J; of modes, the squares of frequencies
    std::size_t modes = 0;       // the first of them, in ascending order
};

// Of cubes of the incompatible element, stiff by their fill. At most `modes` modes, fewer where the
// body has fewer, then six displacements, fewer where some resist nothing. Not converged where not
// all were found.
FineMotions fine_motions(const geometry::Cubes& cubes, int modes, Report& report);

}  // namespace physics
