#pragma once

// The lowest eigenvalues of D (stiffness_matrix.hpp) and their vectors, orthogonal to rigid motions
// that are known beforehand.

#include "physics/modal/shift_inverse.hpp"

namespace physics {

struct Eigenpairs {
    std::vector<double> value;  // ascending
    Eigen::MatrixXd vector;     // orthonormal columns
    bool converged = true;
    int solves = 0;
};

// The lowest `count` of all, each found: for small problems.
Eigenpairs dense_eigenpairs(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                            Eigen::Index count);

// The lowest by restarted Lanczos. One start vector can miss copies of a repeated eigenvalue (the
// two bending directions of a square beam), so the search goes on, orthogonal to what was found,
// until nothing lower turns up. Fewer than `count`, and not converged, where it fails.
// What was found stays in the inverse.
Eigenpairs lanczos_eigenpairs(const StiffnessAndMass& d, Eigen::Index count, ShiftInverse& inverse);

}  // namespace physics
