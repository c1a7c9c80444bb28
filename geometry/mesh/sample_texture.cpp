#include "geometry/mesh/sample_texture.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

// The two pixels of a row or column that a coordinate lies between, and how far it is from one to
// the other.
struct Between {
    std::array<int, 2> pixel{};
    double share = 0;
};

int wrapped(double pixel, int count, TextureUse::Wrap wrap)
{
    const double n = count;
    switch (wrap) {
    case TextureUse::Wrap::repeat:
        pixel -= n * std::floor(pixel / n);
        break;
    case TextureUse::Wrap::mirror:
        pixel -= 2 * n * std::floor(pixel / (2 * n));
        if (pixel >= n) pixel = 2 * n - 1 - pixel;
        break;
    case TextureUse::Wrap::clamp:
        break;
    }
    return static_cast<int>(std::clamp(pixel, 0.0, n - 1));
}

Between between(double coordinate, int count, TextureUse::Wrap wrap)
{
    const double at = coordinate * count - 0.5, low = std::floor(at);
    return {{wrapped(low, count, wrap), wrapped(low + 1, count, wrap)}, at - low};
}

}  // namespace

std::array<double, 4> picture_at(const Picture& picture, const TextureUse& use, const Vec2f& uv)
{
    std::array<double, 4> out{};
    if (picture.width <= 0 || picture.height <= 0 || !uv.allFinite()) return out;
    const Between x = between(double(uv.x()), picture.width, use.u);
    const Between y = between(1 - double(uv.y()), picture.height, use.v);
    for (std::size_t j = 0; j < 2; ++j) {
        for (std::size_t i = 0; i < 2; ++i) {
            const double weight =
                (i == 1 ? x.share : 1 - x.share) * (j == 1 ? y.share : 1 - y.share);
            const auto pixel =
                static_cast<std::size_t>(y.pixel[j]) * static_cast<std::size_t>(picture.width) +
                static_cast<std::size_t>(x.pixel[i]);
            for (std::size_t k = 0; k < 4; ++k) {
                out[k] += weight * double(picture.rgba[4 * pixel + k]) / 255;
            }
        }
    }
    return out;
}

}  // namespace geometry
