#pragma once

// Pairs of particles of different bodies that are near each other.

#include "geometry/base/vec.hpp"

#include <vector>

namespace physics {

using geometry::Vec3;

struct BodyPoint {
    Vec3 at;  // m
    std::uint32_t particle, body;
    bool pinned;
};

// All pairs, those of two bodies with each other together, as groups. Groups of one colour share no
// body, so they can be worked on at the same time; the larger ones of them come first.
struct NearPairs {
    struct Pair {
        std::uint32_t a, b;
    };
    std::vector<Pair> pair;
    std::vector<std::uint32_t> group_at;   // groups + 1, into pair
    std::vector<std::uint32_t> colour_at;  // colours + 1, into group_at
    bool last_alone = false;               // groups of the last colour may share bodies
};

// Pairs of points, of different bodies and not both pinned, that are nearer than `reach` (m). Their
// order depends on the points alone.
NearPairs find_near_pairs(const std::vector<BodyPoint>& points, double reach);

}  // namespace physics
