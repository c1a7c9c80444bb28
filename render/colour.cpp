#include "render/colour.hpp"

#include <algorithm>
#include <cmath>

namespace render {
namespace {

// matplotlib's table (CC0) at 0, 17, 34 ... 255 of 255; straight lines between them stay within
// one 8-bit level of the rest of it.
constexpr std::array<std::array<float, 3>, 16> viridis = {{
    {0.26700f, 0.00487f, 0.32942f},
    {0.28266f, 0.10020f, 0.42216f},
    {0.27713f, 0.18523f, 0.48990f},
    {0.25394f, 0.26525f, 0.52998f},
    {0.22199f, 0.33916f, 0.54875f},
    {0.19063f, 0.40706f, 0.55609f},
    {0.16363f, 0.47113f, 0.55815f},
    {0.13915f, 0.53381f, 0.55530f},
    {0.12057f, 0.59642f, 0.54361f},
    {0.13469f, 0.65864f, 0.51765f},
    {0.20803f, 0.71870f, 0.47287f},
    {0.32780f, 0.77398f, 0.40664f},
    {0.47750f, 0.82144f, 0.31820f},
    {0.64726f, 0.85840f, 0.20986f},
    {0.82494f, 0.88472f, 0.10622f},
    {0.99325f, 0.90616f, 0.14394f},
}};

// Moreland's cool to warm at every eighth of the way.
constexpr std::array<std::array<float, 3>, 9> diverging = {{
    {0.23137f, 0.29804f, 0.75294f},
    {0.38431f, 0.50980f, 0.91765f},
    {0.55294f, 0.69020f, 0.99608f},
    {0.72157f, 0.81569f, 0.97647f},
    {0.86667f, 0.86667f, 0.86667f},
    {0.96078f, 0.76863f, 0.67843f},
    {0.95686f, 0.60392f, 0.48235f},
    {0.87059f, 0.37647f, 0.30196f},
    {0.70588f, 0.01569f, 0.14902f},
}};

template <std::size_t N> Vec3f between(const std::array<std::array<float, 3>, N>& knots, float t)
{
    const float at = t * float(N - 1);
    const std::size_t i = std::min(std::size_t(at), N - 2);
    const float part = at - float(i);
    return (1 - part) * Vec3f(knots[i].data()) + part * Vec3f(knots[i + 1].data());
}

}  // namespace

Vec3f colour_at(ColourMap map, float t)
{
    if (std::isnan(t)) return {1, 0, 1};
    t = std::clamp(t, 0.0f, 1.0f);
    switch (map) {
    case ColourMap::viridis:
        return between(viridis, t);
    case ColourMap::diverging:
        return between(diverging, t);
    case ColourMap::grey:
        break;
    }
    return Vec3f::Constant(0.1f + 0.85f * t);
}

const std::array<float, 256>& light_of_steps()
{
    static const std::array<float, 256> table = [] {
        std::array<float, 256> light{};
        for (std::size_t i = 0; i < light.size(); ++i) {
            light[i] = linear_from_srgb(float(i) / 255);
        }
        return light;
    }();
    return table;
}

std::uint8_t step_of_light(float light)
{
    const float shown = srgb_from_linear(light);
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(shown, 0.0f, 1.0f)));
}

// Hues a golden angle apart: any run of numbers is spread evenly round the circle.
Vec3f category_colour(std::uint32_t i)
{
    const double turn = 0.58 + 0.6180339887498949 * double(i);
    const double hue = 6.283185307179586 * (turn - std::floor(turn));
    const double lightness = i % 3 == 1 ? 0.12 : 0;
    Vec3f colour;
    for (int k = 0; k < 3; ++k) {
        colour[k] = float(0.56 + lightness + 0.27 * std::cos(hue - 2.0943951023931953 * k));
    }
    return colour;
}

}  // namespace render
