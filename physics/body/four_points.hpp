#pragma once

// Four points of sheets that may meet: a point and a triangle, or two edges.

#include "geometry/base/vec.hpp"

#include <array>
#include <optional>
#include <vector>

namespace physics {

using geometry::Vec3;
using FourPoints = std::array<Vec3, 4>;

// point: the first against the triangle of the others. edges: the first two against the last two.
enum class Four { point, edges };

// How they stand: `normal` is across the triangle, or both edges, and sum w_a x_a is the way from
// the nearest place on the triangle, or on the last edge, to the other.
struct Stand {
    std::array<double, 4> weight{};
    Vec3 normal = Vec3::Zero();
    double distance = 0;  // m, along the normal; below 0 behind
};

// None where the nearest place is beyond the triangle, or an edge, or the normal is not known.
std::optional<Stand> stand_of(Four kind, const FourPoints& x);

// When in 0..1 four points that go straight from a to b lie in a plane, ascending; up to three.
struct PlaneTimes {
    std::array<double, 3> at{};
    std::size_t count = 0;
};
PlaneTimes plane_times(const FourPoints& a, const FourPoints& b);

// How they stand where they meet first on the way.
std::optional<Stand> meeting_of(Four kind, const FourPoints& a, const FourPoints& b);

}  // namespace physics
