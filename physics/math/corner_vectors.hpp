#pragma once

// Vector operations of the linear solver, over arrays of four numbers a corner. n is a multiple of
// 16. Sums are taken in 16 lanes on every processor, over runs of fixed length, and the runs in
// order: the result has the same bits on any processor and any number of threads.

#include <cstddef>

namespace physics {

inline constexpr std::size_t vector_lanes = 16;

// y += d * p. Returns p . y.
double add_diagonal_times(std::size_t n, const float* d, const float* p, float* y);
double add_diagonal_times(std::size_t n, const double* d, const double* p, double* y);

// x += alpha p, r -= alpha y, z = inverse * r. Returns r . z.
double descend(std::size_t n, float alpha, const float* p, const float* y, const float* inverse,
               float* x, float* r, float* z);
double descend(std::size_t n, double alpha, const double* p, const double* y, const double* inverse,
               double* x, double* r, double* z);

// r . z
double dot(std::size_t n, const float* r, const float* z);
double dot(std::size_t n, const double* r, const double* z);

// p = z + beta p
void turn_direction(std::size_t n, float beta, const float* z, float* p);
void turn_direction(std::size_t n, double beta, const double* z, double* p);

}  // namespace physics
