#pragma once

// The outermost points of what is drawn, a few that stand for all: a camera that holds them holds
// the rest. They are the farthest along 162 directions, 10 degrees from one another or less, so
// that no point lies outside their hull by more than 1.2 % (1 - cos 9 degrees) of its distance to
// the hull's far side.

#include "geometry/base/vec.hpp"

#include <span>
#include <vector>

namespace render {

using geometry::Box;
using geometry::Vec3f;

struct Extent {
    std::vector<Vec3f> points;  // m; at most 162
};

// Of the finite ones among `points`.
Extent extent_of(std::span<const Vec3f> points);

Box box_of(const Extent& extent);

}  // namespace render
