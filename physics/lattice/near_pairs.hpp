#pragma once

// Pairs of particles that are near each other: of different bodies, and of one where it folds.

#include "geometry/base/vec.hpp"

#include <functional>
#include <vector>

namespace physics {

using geometry::Vec3;

struct BodyPoint {
    Vec3 at;  // m
    std::uint32_t particle, body;
    bool pinned;
};

// All pairs, those of two bodies with each other (or of one with itself) together, as groups.
// Groups of one colour share no body, so they can be worked on at the same time; the larger ones of
// them come first.
struct NearPairs {
    struct Pair {
        std::uint32_t a, b;
    };
    std::vector<Pair> pair;
    std::vector<std::uint32_t> group_at;   // groups + 1, into pair
    std::vector<std::uint32_t> colour_at;  // colours + 1, into group_at
    bool last_alone = false;               // groups of the last colour may share bodies
};

// Whether two particles of one body are near each other because they are near along it.
using NearAlongBody = std::function<bool(std::uint32_t, std::uint32_t)>;

// Pairs of points, not both pinned, that are nearer than `reach` (m): of different bodies, and with
// `along` also of one, but for those of which it is true. Their order depends on the points alone.
NearPairs find_near_pairs(const std::vector<BodyPoint>& points, double reach,
                          const NearAlongBody& along = {});

}  // namespace physics
