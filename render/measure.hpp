#pragma once

// Numbers of a finished picture, for graphs that check what they draw.

#include "render/image.hpp"

namespace render {

// Mean Rec. 709 luma of the stored (sRGB) values, 0..1; 0 for an empty image.
double mean_brightness(const Image& image);

// Share of the pixels that differ from the first of their row by more than 8 levels in a channel:
// over a backdrop that changes with height only, the share that something covers. 0..1.
double coverage(const Image& image);

}  // namespace render
