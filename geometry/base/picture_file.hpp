#pragma once

// Picture files as pixels: PNG, JPEG, BMP and TGA, read by stb_image; and pixels as PNG.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace geometry {

struct Picture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;  // row by row from the top, as a display is sent it
};

struct PictureSize {
    int width = 0, height = 0;
};

// What a picture file says of itself, without reading its pixels. Throws std::runtime_error with
// the end of a sentence ("is not a picture that can be read") unless decode_picture() may try it:
// above 100 million pixels it may not.
PictureSize picture_size(std::string_view file);

// The pixels of a picture file. Throws as picture_size() does, and where the file is damaged.
Picture decode_picture(std::string_view file);

// The picture as a PNG file, which decode_picture() reads back as it was.
std::string encode_png(const Picture& picture);

}  // namespace geometry
