#pragma once

// The colour bar beside a picture: which numbers stand on it, and how it is drawn.

#include "render/image.hpp"
#include "render/placed_text.hpp"
#include "render/scene.hpp"

#include <array>
#include <string>
#include <vector>

namespace render {

// Round numbers (1, 2, 2.5 or 5 times a power of ten apart) from low to high, about `count` of them
// and at least two. None when the interval has no length or is not finite.
std::vector<double> ticks(double low, double high, int count);

// `value` in as few characters as tell it from others `spacing` away: "0.25", "1.2e+09". Beside
// others up to `largest` in size it has as many decimals, and an exponent where that has one.
std::string tick_text(double value, double spacing, double largest = 0);
// All of a scale, equally far apart, in one form.
std::vector<std::string> tick_texts(const std::vector<double>& ticks);

// The interval of `values` widened to round numbers, so that it flickers less from frame to frame.
// Its ends are 0, or 1, 2 or 5 times a power of ten; where all values are farther from 0 than 0.3
// of the farthest one, multiples of a round number. Values alike start at 0. `even`: with values of
// both signs it reaches equally far to either side of 0. What is beyond 0 by less than a thousandth
// of the interval is taken as 0. Numbers that are not finite are passed over; without any others
// 0 to 1.
std::array<float, 2> round_range(const std::vector<float>& values, bool even = false);

struct ClippedRange {
    std::array<float, 2> ends;
    bool clips = false;  // whether values lie beyond them
};

// The interval of `values` without a share `clip` (below 0.5) of them at each end, not rounded.
// Where so few values differ that it has no length, it holds them all. Numbers that are not finite
// are passed over; where all others are alike, it is that of round_range().
ClippedRange percentile_range(std::vector<float> values, double clip);

// Draws the scale with its numbers at the right edge of the picture.
void draw_legend(Image& image, const Legend& legend);
// What its title, its scale and its note take, as far as they are drawn.
std::vector<Area> areas_of(const Legend& legend, int width, int height);
// The share of the picture's width that it takes; 0 where there is no room to draw it.
double width_of(const Legend& legend, int width, int height);

}  // namespace render
