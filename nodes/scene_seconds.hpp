#pragma once

// The time of a frame as it is written into pictures: that of the scene.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace nodes {

inline bool is_real_time(double slow_motion)
{
    return std::abs(slow_motion - 1) < 0.005;
}

// "0.031 s" of a time of the video, s, that is so many times slower than the scene, with as many
// more decimals.
inline std::string seconds_text(double time, double slow_motion)
{
    const int more = static_cast<int>(std::ceil(std::log10(slow_motion) - 1e-9));
    const int decimals = is_real_time(slow_motion) ? 2 : 2 + std::max(0, more);
    // Halves are exact in few places of a grid of frames: they go up, as people round.
    const double scale = std::pow(10, decimals), seconds = time / slow_motion;
    return fmt::format("{:.{}f} s", std::round(seconds * scale * (1 + 1e-12)) / scale, decimals);
}

}  // namespace nodes
