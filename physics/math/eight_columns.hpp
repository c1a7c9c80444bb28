#pragma once

// Tall matrices of eight columns, kept row by row: what block methods work on. A number that is
// read once serves eight columns, and a row fills one vector of the widest processors. Sums are
// taken over runs of fixed length, and the runs in order: the result has the same bits on any
// processor and any number of threads.

#include "physics/math/aligned_memory.hpp"

#include <Eigen/Core>

#include <cstddef>

namespace physics {

inline constexpr std::size_t eight = 8;

using EightColumns = Aligned<double>;  // rows x 8
using Eights = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>;

// A^T B.
Eights transposed_times(const EightColumns& a, const EightColumns& b);

// C -= A b.
void subtract_times(const EightColumns& a, const Eights& b, EightColumns& c);

// Rows of a sparse matrix of numbers, as Eigen keeps them: those of row i are first[i] to
// first[i + 1].
struct SparseRows {
    const int* first = nullptr;
    const int* column = nullptr;
    const double* number = nullptr;
};

// to = A x for a matrix of n rows, each number of which stands for three equal ones on a diagonal:
// x and `to` have three rows for each of its columns and rows.
void times_in_threes(std::size_t n, const SparseRows& a, const EightColumns& x, EightColumns& to);

// Solves L y = x and L^T x = y in place for the front of a factor (dense_front.hpp): `columns` hold
// L11 over L21, x has pivots + border rows. Going down, L21 y is taken from the rows of the border;
// going up, these are known, and L21^T x counts.
void solve_down(std::size_t pivots, std::size_t border, const double* columns, double* x);
void solve_up(std::size_t pivots, std::size_t border, const double* columns, double* x);
// The same for rows of four.
void solve_four_down(std::size_t pivots, std::size_t border, const double* columns, double* x);
void solve_four_up(std::size_t pivots, std::size_t border, const double* columns, double* x);

}  // namespace physics
