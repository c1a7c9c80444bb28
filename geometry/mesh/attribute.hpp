#pragma once

// Numbers at vertices or samples.

#include <string>
#include <vector>

namespace geometry {

// One named number a vertex, or a sample, for colouring and export: displacement, speed, stress,
// component; or one of the user's own.
struct Attribute {
    std::string name;           // "displacement"
    std::string unit;           // "m"
    std::vector<float> values;  // V
};

}  // namespace geometry
