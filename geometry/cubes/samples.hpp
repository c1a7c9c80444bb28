#pragma once

// Points that each stand for a bit of mass.

#include "geometry/base/vec.hpp"
#include "geometry/cubes/matter.hpp"
#include "geometry/mesh/attribute.hpp"

#include <vector>

namespace geometry {

// Points spread over a surface or through a volume, each standing for a bit of mass.
struct Samples {
    std::vector<Vec3f> positions;         // N, m
    std::vector<float> mass;              // N, kg
    std::vector<std::uint16_t> matter;    // N, into matters
    std::vector<std::uint32_t> triangle;  // N, the triangle each lies on; empty for volume samples
    std::vector<Matter> matters;          // at least one
    std::vector<Attribute> attributes;    // any number, N each

    // What they are to cubes. A sample fills bulk * mass / density of its matter, in m^3; 0: a cube
    // that holds any is full of them.
    double bulk = 1;
    double total_mass = 0;  // kg, of all cubes together; 0: what filled volume and density give
};

}  // namespace geometry
