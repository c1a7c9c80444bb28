#pragma once

// What the renderer's tests share.

#include "geometry/mesh/primitive.hpp"
#include "render/draw.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace tests {

inline render::Surface surface(geometry::TriMesh mesh)
{
    render::Surface out;
    out.mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
    return out;
}

inline geometry::Box box_about_origin(double half)
{
    geometry::Box box;
    box.add(geometry::Vec3(geometry::Vec3::Constant(half)));
    box.add(geometry::Vec3(geometry::Vec3::Constant(-half)));
    return box;
}

// A small square picture without anything that is not asked for.
inline render::Look plain_look(int size = 128)
{
    render::Look look;
    look.width = look.height = size;
    look.antialias = render::Antialias::none;
    look.shadow = render::ShadowQuality::off;
    look.grid = false;
    look.backdrop_top = look.backdrop_horizon = {0, 0, 0.5f};
    return look;
}

inline std::array<int, 3> pixel(const render::Image& image, int x, int y)
{
    const std::size_t i = 4 * (std::size_t(y) * std::size_t(image.width) + std::size_t(x));
    return {image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]};
}

// Not the blue that plain_look() has behind everything.
inline bool covered(const render::Image& image, int x, int y)
{
    const auto p = pixel(image, x, y);
    return p[0] > 2 || p[1] > 2 || p[2] < 180 || p[2] > 195;
}

inline int covered_pixels(const render::Image& image)
{
    int sum = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) sum += covered(image, x, y) ? 1 : 0;
    }
    return sum;
}

}  // namespace tests
