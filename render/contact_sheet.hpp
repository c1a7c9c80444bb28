#pragma once

// Many pictures on one sheet, each with a label; and pictures at another size.

#include "render/image.hpp"

#include <string>
#include <vector>

namespace render {

// `image` at another size, filtered so that fine lines do not break up: in linear light, by the
// Mitchell filter. Throws std::invalid_argument for an image or a size without pixels.
Image resized(const Image& image, int width, int height);

struct Tile {
    const Image* image = nullptr;
    std::string label;
};

// The tiles side by side in `columns` columns, each with its label below, in as many lines as it
// takes, on one sheet `width` pixels wide. All take the shape of the first. Throws
// std::invalid_argument without tiles.
Image contact_sheet(const std::vector<Tile>& tiles, int columns, int width);

// `count` frames from first to last, both among them, as evenly spaced as whole numbers go; all of
// them when there are no more.
std::vector<int> spread_frames(int first, int last, int count);

}  // namespace render
