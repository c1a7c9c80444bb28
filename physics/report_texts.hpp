#pragma once

// What several methods say in their reports. No number in it changes much from frame to frame, for
// each other text is told again.

#include <string>

namespace physics {

// Of `inverted` > 0 cubes of all.
inline std::string told_of_inverted(std::size_t inverted, std::size_t all)
{
    const bool few = 4 * inverted < all;
    return std::string(few ? "some cubes" : "a quarter of the cubes, or more,") +
           " are squashed flat or turned inside out; a stiffer material or more substeps would "
           "hold them";
}

}  // namespace physics
