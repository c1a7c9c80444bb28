#pragma once

// Lines in space that run through points: wires, guides, curves that were drawn.

#include "geometry/base/vec.hpp"

#include <vector>

namespace geometry {

struct Polylines {
    // m: of each line, two points or more, in order. A closed one ends where it begins.
    std::vector<std::vector<Vec3>> lines;
};

}  // namespace geometry
