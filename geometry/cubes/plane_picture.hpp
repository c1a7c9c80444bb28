#pragma once

// Pictures that say which cells a plane has.

#include <filesystem>
#include <vector>

namespace geometry {

// A picture as numbers from 0 to 1, row by row from the top.
struct PlanePicture {
    int width = 0, height = 0;
    std::vector<float> value;
};

// What of a picture is meant: where it is dark, bright or opaque.
enum class PictureInk { dark, bright, opaque };

// Throws std::runtime_error when the file is no picture that can be read (PNG, JPEG, BMP, TGA), or
// above 100 million pixels.
PlanePicture read_plane_picture(const std::filesystem::path& path, PictureInk ink);

}  // namespace geometry
