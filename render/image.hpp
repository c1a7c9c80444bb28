#pragma once

// A picture in memory: what drawing gives and what is written to files.

#include <cstdint>
#include <vector>

namespace render {

// 8-bit sRGB colour with alpha, rows from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  // height * width * 4
    // The same picture as light, before it is made for the eye; empty where nobody asked for it.
    std::vector<std::uint16_t> light =
        {};                         // height * width * 4, half floats: RGB times alpha, alpha
    std::vector<float> depth = {};  // height * width, m along the view; see nothing_there
};

// The depth where nothing is, as Blender writes it.
inline constexpr float nothing_there = 1e10f;

}  // namespace render
