#pragma once

#include "geometry/vec.hpp"

namespace render {

using geometry::Vec3f;

// fxaa smooths the finished picture; samples4 lights four points of a pixel where they differ.
enum class Antialias { none, fxaa, samples4 };
enum class ShadowQuality { off, low, medium, high };

// How a scene is shown. Colours are linear RGB.
struct Look {
    int width = 960, height = 540;
    Antialias antialias = Antialias::fxaa;
    ShadowQuality shadow = ShadowQuality::medium;

    double light_azimuth = -0.4, light_elevation = 0.9;  // radians, as in direction()
    Vec3f light{1.0f, 0.95f, 0.87f};  // what a white surface that faces the key light sends out
    Vec3f sky{0.31f, 0.34f, 0.39f}, bounce{0.20f, 0.19f, 0.18f};  // light from above and below
    Vec3f backdrop_top{0.10f, 0.12f, 0.15f}, backdrop_horizon{0.40f, 0.42f, 0.45f};
    Vec3f floor{0.34f, 0.34f, 0.34f};  // albedo
    bool grid = true;
};

}  // namespace render
