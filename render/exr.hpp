#pragma once

// Pictures as OpenEXR files: scene-linear light for compositing.

#include "render/image.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace render {

// Writes the light of `image` as an EXR: half-float R, G, B and A, premultiplied, of the primaries
// of sRGB, and the depth as a float channel Z where there is one. The file appears whole or not at
// all; missing folders are made. Throws std::runtime_error naming the file and why, and as
// encode_exr() does.
void write_exr(const std::filesystem::path& path, const Image& image);

// The bytes of an EXR, compressed without loss (ZIP). Throws std::invalid_argument when the image
// has no light, or not as much as its size says.
std::string encode_exr(const Image& image);

// The nearest half floats, ties to even; what is too large for one becomes the largest.
std::vector<std::uint16_t> halves(std::span<const float> values);
// What a half float stands for.
float of_half(std::uint16_t half);

}  // namespace render
