#pragma once

// The lowest modes: K phi = omega^2 M phi, orthogonal to rigid motions that are known beforehand.

#include "physics/modal/shift_inverse.hpp"

namespace physics {

struct Eigenpairs {
    std::vector<double> value;  // omega^2, ascending
    Eigen::MatrixXd vector;     // columns phi, phi^T M phi = I
    bool converged = true;
};

// Whether a dense solver is the better one.
inline bool few_unknowns(Eigen::Index rows, Eigen::Index count)
{
    return rows <= 120 || 3 * count + 30 > rows;
}

// The lowest `count` of all, each found.
Eigenpairs dense_eigenpairs(const StiffnessAndMass& d, const std::vector<RigidMotions>& rigid,
                            Eigen::Index count);

// The lowest by block Lanczos, eight vectors at a time, restarted with the best. (Grimes, Lewis,
// Simon. A shifted block Lanczos algorithm for solving sparse symmetric generalized eigenproblems.
// SIAM J. Matrix Anal. Appl. 15(1), 1994. Wu, Simon. Thick-restart Lanczos method. SIAM J. Matrix
// Anal. Appl. 22(2), 2000.) Eight vectors find up to eight copies of a repeated eigenvalue; where
// that many are found, the search goes on, orthogonal to what was found, until nothing lower turns
// up. Fewer than `count`, and not converged, where it fails. The inverse leaves out what was found.
Eigenpairs lanczos_eigenpairs(Eigen::Index count, ShiftInverse& inverse);

}  // namespace physics
