#pragma once

#include "geometry/matter.hpp"
#include "geometry/vec.hpp"

#include <vector>

namespace geometry {

// Points spread over a surface or through a volume, each standing for a bit of mass.
struct Samples {
    std::vector<Vec3f> positions;         // N, m
    std::vector<float> mass;              // N, kg
    std::vector<std::uint16_t> matter;    // N, into matters
    std::vector<std::uint32_t> triangle;  // N, the triangle each lies on; empty for volume samples
    std::vector<Matter> matters;          // at least one
};

}  // namespace geometry
