#pragma once

// How a scene is shown, whatever is in it: light, shadows, antialiasing, background.

#include "geometry/base/vec.hpp"

namespace render {

using geometry::Vec3f;

// fxaa smooths the finished picture; samples4 lights four points of a pixel where they differ;
// samples16 is the mean of sixteen pictures.
enum class Antialias { none, fxaa, samples4, samples16 };
enum class ShadowQuality { off, low, medium, high };

// studio: the materials' colours under soft light in a bright studio. clay: the same, all of one
// clay. diagram: flat colours and outlines on white. matcap: lit by the normal alone, as the camera
// sees it. plain: one hard key light over a grey floor.
enum class Style { studio, clay, diagram, matcap, plain };
inline constexpr int style_count = 5;

// Whether a picture comes as linear light too. whole: as it is seen, alpha 1. cut_out: without the
// backdrop; alpha is what things and the floor cover. As in shaders/shade.glsl.
enum class Linear { none, whole, cut_out };

// How a scene is shown. Colours are linear RGB.
struct Look {
    int width = 960, height = 540;
    Antialias antialias = Antialias::fxaa;
    ShadowQuality shadow = ShadowQuality::medium;
    Style style = Style::plain;
    Linear linear = Linear::none;
    // Whether shadows soften with distance and light is kept from corners: a pass of its own.
    bool soft = false;

    double light_azimuth = -0.4, light_elevation = 0.9;  // radians, as in direction()
    double light_size = 0.14;         // radians, how wide the key light is seen: soft only
    double occlusion = 1, rim = 0;    // strengths: of corners' shade (soft only), light from behind
    Vec3f light{1.0f, 0.95f, 0.87f};  // what a white surface that faces the key light sends out
    Vec3f sky{0.31f, 0.34f, 0.39f}, bounce{0.20f, 0.19f, 0.18f};  // light from above and below
    Vec3f backdrop_top{0.10f, 0.12f, 0.15f}, backdrop_horizon{0.40f, 0.42f, 0.45f};
    Vec3f floor{0.34f, 0.34f, 0.34f};  // albedo
    bool grid = true;
    // Clear things as glass: their shadows are as light as they are clear, and they mirror the sky.
    bool glass = false;

    // Motion blur: the mean of `exposures` pictures, from `shutter` frames ago until now; 0: none.
    double shutter = 0;  // 0..1, of the way from where things were a frame ago
    int exposures = 8;
};

}  // namespace render
