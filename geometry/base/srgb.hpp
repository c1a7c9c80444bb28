#pragma once

// Between light and display values: IEC 61966-2-1, sRGB. Components in 0..1.

#include "geometry/base/vec.hpp"

#include <cmath>

namespace geometry {

inline float linear_from_srgb(float c)
{
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
}
inline float srgb_from_linear(float c)
{
    return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
}
inline Vec3f linear_from_srgb(const Vec3f& c)
{
    return c.unaryExpr([](float x) { return linear_from_srgb(x); });
}
inline Vec3f srgb_from_linear(const Vec3f& c)
{
    return c.unaryExpr([](float x) { return srgb_from_linear(x); });
}

}  // namespace geometry
