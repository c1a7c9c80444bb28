#pragma once

// The rotational part of many matrices at a time (polar decomposition), warm-started. The method
// and its safety net stand in rotation-inl.hpp, which kernels with a loop of their own fuse.

#include "geometry/base/vec.hpp"

#include <cstddef>

namespace physics {

using geometry::Mat3;

// Quaternions of the rotations nearest to n matrices (the R that maximises tr(R^T A)), always
// proper, also for singular and mirrored matrices. Entry k = 3 row + column of matrix i is
// a[k * a_stride + i]. Component k of (w, x, y, z) of quaternion i is q[k * q_stride + i]: the
// rotation found last time on entry (zeros: none), that of A on return. Where many rotations are
// equally near (rank 0 or 1), the one nearest to the last is taken; a matrix that is not finite
// leaves its quaternion. The bits do not depend on n, the place of a matrix, or the processor.
void extract_rotations(std::size_t n, const float* a, std::size_t a_stride, float* q,
                       std::size_t q_stride);
void extract_rotations(std::size_t n, const double* a, std::size_t a_stride, double* q,
                       std::size_t q_stride);

// The same in 2D: a holds 4 planes, cs the planes of cosine and sine.
void extract_rotations_2d(std::size_t n, const float* a, std::size_t a_stride, float* cs,
                          std::size_t cs_stride);
void extract_rotations_2d(std::size_t n, const double* a, std::size_t a_stride, double* cs,
                          std::size_t cs_stride);

// One matrix.
Eigen::Quaterniond
extract_rotation(const Mat3& a, const Eigen::Quaterniond& last = Eigen::Quaterniond::Identity());

}  // namespace physics
