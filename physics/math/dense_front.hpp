#pragma once

// Cholesky factorisation of the dense matrix of one front (bricks/direct_factor.hpp), in blocks of
// columns:
//
//     A11            A11 = L11 L11^T
//     A21 A22        L21 = A21 L11^-T        A22 - L21 L21^T remains
//
// Products go tile by tile through registers (Goto, van de Geijn. Anatomy of high-performance
// matrix multiplication. ACM TOMS 34(3), 2008). Each number is a sum in one order, without fused
// operations: the result has the same bits on any processor and any number of threads.

#include <cstddef>

namespace physics {

// Factors the first `pivots` columns of a symmetric matrix of pivots + border rows, of which only
// the lower triangle is read: `columns` holds these columns, one after the other, and gets L11 over
// L21; `rest` (border x border, by columns) becomes what remains of it. What lies above the
// diagonals is left undefined. False when a pivot is not positive.
bool eliminate_front(std::size_t pivots, std::size_t border, double* columns, double* rest);

}  // namespace physics
