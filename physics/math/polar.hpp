#pragma once

// The rotation in a matrix: F = R S, R a rotation, S symmetric. Where det F < 0 the least of S's
// eigenvalues is below zero.

#include "geometry/base/vec.hpp"

#include <Eigen/SVD>

namespace physics {

struct Polar {
    geometry::Mat3 R, U;     // U: axes of R S R^T, as columns
    geometry::Vec3 stretch;  // eigenvalues of S, the least last
};

inline Polar polar_of(const geometry::Mat3& F)
{
    const Eigen::JacobiSVD<geometry::Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Polar out;
    out.U = svd.matrixU();
    out.stretch = svd.singularValues();
    if ((out.U * svd.matrixV().transpose()).determinant() < 0) {
        out.U.col(2) *= -1;
        out.stretch[2] *= -1;
    }
    out.R = out.U * svd.matrixV().transpose();
    return out;
}

}  // namespace physics
