#pragma once

// The field at many points, wherever they lie, on all threads.
// Points that come in no order are sorted into cells first, so that a block holds neighbours.

#include "geometry/fields/field.hpp"

namespace geometry {

// f at each point, and its gradient where `gradient` is not empty. A point that is not finite lies
// outside everything. Spans of unequal length throw std::invalid_argument.
void evaluate(const Field& field, std::span<const Vec3> points, std::span<double> f,
              std::span<Vec3> gradient = {});

}  // namespace geometry
