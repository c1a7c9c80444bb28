#pragma once

// Text for labels and legends, drawn from strokes that are built in: no font file is needed, and
// any size is sharp.

#include "geometry/base/vec.hpp"
#include "render/image.hpp"

#include <string>
#include <string_view>

namespace render {

using geometry::Vec2f;
using geometry::Vec3f;

struct TextStyle {
    float height = 10;              // pixels, of a capital letter
    Vec3f colour{1, 1, 1};          // sRGB
    Vec3f halo{0.1f, 0.1f, 0.12f};  // sRGB, around the letters, so that they stand off anything
    float halo_opacity = 0.85f;
};

// Pixels, of capital letters in a picture of this size: of 960 x 540 they are read in tiles of a
// contact sheet that is 1600 wide and has four columns.
float letter_height(int width, int height);

// Pixels: what makes room for others gets no lower.
inline constexpr float least_letter = 7;

// Width of a line of text in pixels.
float text_width(std::string_view text, float height);

// Draws one line with its baseline's left end at `at` (pixels from the upper left corner, y down).
// The text is UTF-8; what has no glyph comes out as a box. What lies outside the image is cut off.
void draw_text(Image& image, std::string_view text, const Vec2f& at, const TextStyle& style);

// Takes the last letter off, of one byte or several.
void cut_last_letter(std::string& text);

// Each letter of `text` once that comes out as a box.
std::string without_glyphs(std::string_view text);

}  // namespace render
