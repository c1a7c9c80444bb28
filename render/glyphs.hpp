#pragma once

// The letters of text.hpp: ASCII, and by UTF-8 Latin-1, Latin Extended-A, Greek and some signs.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace render {

// Strokes, parted by commas. A point is a digit for x and a hexadecimal digit for y: descenders end
// at 0, the baseline is 3, small letters reach 8 and capitals b. A stroke that starts with ~ is a
// quadratic B-spline: it leaves the first point, ends in the last, and passes the middles between
// the others.
struct Glyph {
    int width;
    const char* strokes;
};

// A mark above or below a letter.
struct PlacedMark {
    const char* strokes = "";
    float right = 0, up = 0;  // glyph units, from where the strokes say
};

struct Letter {
    Glyph base;
    float width = 0, right = 0;  // glyph units, and where the base lies in them
    std::array<PlacedMark, 2> marks{};
};

// The next code point of UTF-8, which is taken off `text`; 0xfffd for a byte that begins none.
char32_t next_letter(std::string_view& text);

// A box for what is not there.
Letter letter_of(char32_t code);
bool is_drawn(char32_t code);

}  // namespace render
