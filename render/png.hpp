#pragma once

// Images as PNG files.

#include "render/image.hpp"

#include <filesystem>

namespace render {

// Writes `image` as a PNG. The file appears whole or not at all, and nothing else of it is left
// when the process is killed; missing folders are made. Throws std::runtime_error naming the file
// and why.
void write_png(const std::filesystem::path& path, const Image& image);

// The bytes of a PNG of `image`. Throws std::invalid_argument when the image has no pixels, or not
// as many as its size says, or more than 2 GB.
std::vector<std::uint8_t> encode_png(const Image& image);

}  // namespace render
