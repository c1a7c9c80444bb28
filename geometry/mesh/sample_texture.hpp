#pragma once

// Pictures as numbers at texture coordinates: maps of stiffness, masks, weights.

#include "geometry/mesh/texture.hpp"
#include "geometry/mesh/texture_use.hpp"

#include "geometry/base/vec.hpp"

#include <array>

namespace geometry {

// Red, green, blue and alpha of a picture where u and v are, 0..1 as the file has them: linear
// between the middles of its pixels. u runs to the right, v up; both are 0..1 over the picture, and
// TextureUse says what is beyond. All 0 for a picture without pixels, and where u or v is not
// finite.
std::array<double, 4> picture_at(const Picture& picture, const TextureUse& use, const Vec2f& uv);

}  // namespace geometry
