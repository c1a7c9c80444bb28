#pragma once

// Lines of text with their places, so that what is written into a picture can keep clear of what
// else is.

#include "render/text.hpp"

#include <span>
#include <string>

namespace render {

// Pixels from the upper left corner, y down.
struct Area {
    float left = 0, top = 0, right = 0, bottom = 0;
};

bool meet(const Area& a, const Area& b);

struct PlacedText {
    std::string text;
    Vec2f at{0, 0};  // the baseline's left end, pixels
    float height = 10;
};

// What its letters take, with a pixel around them. Halos reach farther: they cover no letters.
Area area_of(const PlacedText& text);

// Pixels that a line which starts there has: up to as much before the right edge of a picture so
// wide, or to a letter before what is `taken` beside it.
float room_of(const PlacedText& line, int width, std::span<const Area> taken);

// As much of `text` as is no wider than `room`, with "..." where some of it is left out; empty
// where that has no room.
std::string cut_to(const std::string& text, float height, float room);

void draw_texts(Image& image, std::span<const PlacedText> texts);

}  // namespace render
