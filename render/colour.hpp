#pragma once

// Maps from numbers to colours.

#include "geometry/base/srgb.hpp"

#include <array>
#include <cstdint>

namespace render {

using geometry::Vec3f;

using geometry::linear_from_srgb;
using geometry::srgb_from_linear;

// Even in perceived lightness, so that equal steps look equal. `viridis`: Smith and van der Walt,
// matplotlib, 2015. `diverging`: Moreland, Diverging color maps for scientific visualization, 2009.
enum class ColourMap { viridis, diverging, grey };

// sRGB at t in 0..1 (clamped; not-a-number gives magenta, which no map holds).
Vec3f colour_at(ColourMap map, float t);

// A map over an interval of values.
struct ColourScale {
    ColourMap map = ColourMap::viridis;
    float low = 0, high = 1;

    // Where `value` lies: 0 at low, 1 at high. An interval without length gives 0.
    float place(float value) const { return high > low ? (value - low) / (high - low) : 0; }
};

// Of the 256 steps of a picture's colours, as light.
const std::array<float, 256>& light_of_steps();

// And back: the nearest step.
std::uint8_t step_of_light(float light);

// A colour for category `i`: neighbours in number look unlike each other. sRGB.
Vec3f category_colour(std::uint32_t i);

}  // namespace render
