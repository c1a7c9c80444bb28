#pragma once

// What several methods say in their reports. Numbers in it are round, so that frames that differ a
// little say the same.

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace physics {

// The last of 1, 2, 5, 10, 20, 50 ... up to v, the first from v on; v > 0.
inline double round_down(double v)
{
    const double ten = std::pow(10, std::floor(std::log10(v)));
    return v >= 5 * ten ? 5 * ten : v >= 2 * ten ? 2 * ten : ten;
}
inline double round_up(double v)
{
    const double ten = std::pow(10, std::floor(std::log10(v)));
    return v <= ten ? ten : v <= 2 * ten ? 2 * ten : v <= 5 * ten ? 5 * ten : 10 * ten;
}

// A cube with a smaller share of its volume counts as inverted.
inline constexpr double least_volume = 0.1;

inline std::string told_of_inverted(std::size_t cubes)
{
    if (cubes == 1) return "a cube is squashed flat or turned inside out";
    return fmt::format("{}{} cubes are squashed flat or turned inside out",
                       cubes > 2 ? "at least " : "", round_down(double(cubes)));
}

}  // namespace physics
