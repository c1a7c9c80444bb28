#pragma once

// Two pictures as one, so that an eye can tell what differs.

#include "render/image.hpp"

#include <string>

namespace render {

// side_by_side: a on the left, b on the right. wipe: a left of a line, b right of it. difference:
// how far each pixel of b is from that of a, by colours.
enum class CompareMode { side_by_side, wipe, difference };

struct Comparison {
    CompareMode mode = CompareMode::side_by_side;
    double wipe = 0.5;             // where the line stands: 0 at the left edge, 1 at the right
    double gain = 4;               // the scale of differences ends at 1 / gain of black to white
    std::string label_a, label_b;  // told at the top of each; empty: nothing
};

// Both sides of a picture keep their pixels, with a gap between them side by side. The scale of
// differences is the same for all pictures of a gain, and is drawn over their right. Linear light
// and depths are not compared: the result has none. Throws std::invalid_argument for pictures of
// different sizes, or without pixels.
Image compare(const Image& a, const Image& b, const Comparison& how);

}  // namespace render
