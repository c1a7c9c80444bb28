#pragma once

// Dense matrix times vector in single precision, by columns. `rows` is a multiple of 16 and the
// columns lie one after the other. The result has the same bits on any processor.

#include <cstddef>

namespace physics {

// y += A x.
void add_columns(std::size_t rows, std::size_t columns, const float* a, const float* x, float* y);

// out[j] = column j . x
void column_dots(std::size_t rows, std::size_t columns, const float* a, const float* x, float* out);

}  // namespace physics
