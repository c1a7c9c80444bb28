#pragma once

// Four numbers that are added as one: what sums over regions are made of.

#include <Eigen/Core>

namespace physics {

template <class T> using Quad = Eigen::Array<T, 4, 1>;

}  // namespace physics
