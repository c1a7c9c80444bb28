#pragma once

// What of a solid skeleton's core is its own, where skeletons of one body overlap.
//
//    +-------.-----+
//    |  A  o : o   |        Each point belongs to the skeleton whose contribution is largest there,
//    |   +---:-----+---+    as the territories of samples do (sample_walk.hpp): what two have in
//    +---+---:-----+   |    common is counted once. Found on an even grid of the core's points.
//        |   :   B     |
//        +-------------+

#include "geometry/fields/field.hpp"

namespace physics {

using geometry::Field;
using geometry::Vec3;

struct OwnCore {
    std::vector<Vec3> points;  // m, of the grid, that no other skeleton takes
    std::size_t count = 0;     // how many lie in the core

    bool is_whole() const { return points.size() == count; }
    double share() const
    {
        return is_whole() ? 1 : static_cast<double>(points.size()) / static_cast<double>(count);
    }
};

// Of skeleton s of a body as drawn. Whole, without points, for what has no core of its own volume,
// and where no other skeleton is near.
OwnCore own_core(const Field& field, std::uint32_t s);

}  // namespace physics
