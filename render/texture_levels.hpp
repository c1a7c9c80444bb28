#pragma once

// A picture at half, a quarter ... of its size, for what is seen from afar.
//   Williams. Pyramidal parametrics. SIGGRAPH 1983.
// Means are taken of light, not of display values, and a texel counts for as much as it is opaque:
// what lies under transparent texels tints no rim. Of a normal map, means are taken of the numbers
// themselves. No layer is linked: aspic-draw has it too.

#include <cstdint>
#include <span>
#include <vector>

namespace render {

struct TextureLevel {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;
};

// The picture itself, at most `largest` texels along each side, and its smaller levels, down to one
// texel. A level has half the texels of the one before along each side, rounded down; each of them
// covers its share of the picture exactly.
std::vector<TextureLevel> texture_levels(int width, int height, std::span<const std::uint8_t> rgba,
                                         int largest, bool normals = false);

}  // namespace render
