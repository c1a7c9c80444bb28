#pragma once

// Four points of sheets that may meet: a point and a triangle, or two edges.

#include "geometry/base/vec.hpp"

#include <array>
#include <cmath>
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

// The same, with the normal to the side of `way`.
Stand turned_to(Stand stand, const Vec3& way);

// How four points that go from a to b stand, with the normal out of the side that is to be kept:
// that of `grip`, if any, else where they stand at the start when they are nearer than `reach` (m),
// the one that they come from, and where they stand at the end. Where `grip` is null and they
// stand at all, beside() may give another one; own(stand) tells on which side they stand.
template <class Grip, class Beside, class Own>
std::optional<Stand> side_to_keep(Four kind, const FourPoints& a, const FourPoints& b, double reach,
                                  const Grip* grip, const Beside& beside, const Own& own)
{
    constexpr double same_normal = 0.5;  // cosine
    const auto start = stand_of(kind, a), end = stand_of(kind, b);
    if (!start && !end && grip) return std::nullopt;
    if (!grip && (start || end)) grip = beside();
    if (grip) {
        const Stand& stand = end ? *end : *start;
        const Vec3 side = grip->normal.template cast<double>();
        // Edges that have come past each other have another normal.
        if (std::abs(stand.normal.dot(side)) > same_normal) return turned_to(stand, side);
    }
    if (start && std::abs(start->distance) < reach && start->distance != 0) {
        const Stand side = own(*start);
        if (end && std::abs(end->normal.dot(side.normal)) > same_normal) {
            return turned_to(*end, side.normal);
        }
        return side;
    }
    if (const auto meeting = meeting_of(kind, a, b)) {
        Vec3 way = Vec3::Zero();
        for (std::size_t i = 0; i < 4; ++i) way += meeting->weight[i] * (a[i] - b[i]);
        return turned_to(*meeting, way);
    }
    if (!end || !(std::abs(end->distance) < reach)) return std::nullopt;
    return own(*end);
}

}  // namespace physics
