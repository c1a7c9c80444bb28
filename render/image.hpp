#pragma once

// A picture in memory: what drawing gives and what is written to files.

#include <cstdint>
#include <vector>

namespace render {

// 8-bit sRGB colour with alpha, rows from the top.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  // height * width * 4
};

}  // namespace render
