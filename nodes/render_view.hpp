#pragma once

// The parameters of Render that do not depend on what is drawn: viewpoint, light, ground, backdrop.

#include "geometry/base/vec.hpp"
#include "graph/types/param_builder.hpp"
#include "render/camera.hpp"
#include "render/look.hpp"

#include <algorithm>

namespace nodes::render {

using geometry::Vec3;
using geometry::Vec3f;

struct CameraParams {
    enum class Kind { fit, turntable, look_at } kind = Kind::fit;
    double azimuth = 35, elevation = 20, turn = 3, margin = 0.06;
    Vec3 eye{3, 2, 4}, target{0, 0, 0};
    double field_of_view = 28;
    bool parallel = false;
    enum class Hold { shape, box } hold = Hold::shape;
    enum class Views { one, four } views = Views::one;
};

struct LightParams {
    double azimuth = -25, elevation = 50, strength = 1, fill = 1, size = 8, rim = 0.7,
           occlusion = 1;
    Vec3f colour{1, 0.95f, 0.87f};
    ::render::ShadowQuality shadow = ::render::ShadowQuality::medium;
};

struct GroundParams {
    enum class Kind { none, under, at } kind = Kind::under;
    double height = 0;
    bool grid = false;
    Vec3f colour{0.70f, 0.69f, 0.67f};
};

struct BackdropParams {
    Vec3f top{0.20f, 0.25f, 0.32f}, horizon{0.52f, 0.56f, 0.61f};
};

inline void describe(graph::ParamsOf<CameraParams>& p)
{
    p.choice("kind", &CameraParams::kind, {"fit", "turntable", "look_at"},
             "`fit` holds the whole stage in the picture; `turntable` does too, and goes round it; "
             "`look_at` stands at `eye`.")
        .choice(
            "hold", &CameraParams::hold, {"shape", "box"},
            "What is held: the points of `shot`, or else of `rest`, so that `margin` is what is "
            "free around them (of points, around their balls), or the corners of their box. "
            "Without either it is the box of "
            "what is drawn. A camera at `eye` holds nothing; the parallel ones of four views do.")
        .param("azimuth", &CameraParams::azimuth,
               "Where the camera stands, seen from above: 0 towards +z, 90 towards +x.",
               {.unit = "deg"}, {"kind", {"fit", "turntable"}})
        .param("elevation", &CameraParams::elevation,
               "How far above the horizon the camera stands.", {-89, 89, "deg"},
               {"kind", {"fit", "turntable"}})
        .param("turn", &CameraParams::turn, "How far the camera goes round in each frame.",
               {.unit = "deg"}, {"kind", {"turntable"}})
        .param(
            "margin", &CameraParams::margin,
            "Share of the picture's width and height left free on each side; on the right as much "
            "as a legend takes, where that is more. Of a camera at `eye`, it is that of the "
            "parallel ones of four views.",
            {0, 0.45})
        .param("eye", &CameraParams::eye, "Where the camera stands.", {.unit = "m"},
               {"kind", {"look_at"}})
        .param("target", &CameraParams::target, "What the camera looks at.", {.unit = "m"},
               {"kind", {"look_at"}})
        .param("field_of_view", &CameraParams::field_of_view,
               "Angle that the picture's height spans; small flattens perspective.",
               {1, 150, "deg"})
        .param(
            "parallel", &CameraParams::parallel,
            "Whether the projection is parallel (orthographic): then far things look as large "
            "as near ones. A camera that fits needs no `field_of_view` then; one that looks at a "
            "target shows as much as it would of a plane there.")
        .choice("views", &CameraParams::views, {"one", "four"},
                "four: the picture has four parts, at the left the top above the front, at the "
                "right what the camera sees above the right side. The other three are parallel, in "
                "line and of one scale, and hold the stage.");
}

inline void describe(graph::ParamsOf<LightParams>& p)
{
    p.param("azimuth", &LightParams::azimuth,
            "Where the key light comes from, seen from above: 0 from +z, 90 from +x.",
            {.unit = "deg"})
        .param("elevation", &LightParams::elevation, "How far above the horizon the key light is.",
               {1, 90, "deg"})
        .param("strength", &LightParams::strength, "Strength of the key light.", {0, 20})
        .param("fill", &LightParams::fill, "Strength of the light from all around.", {0, 20})
        .param("size", &LightParams::size,
               "Angle that the key light spans, seen from the scene: shadows soften with it and "
               "with distance. The sun spans 0.5.",
               {0, 30, "deg"})
        .param("rim", &LightParams::rim, "Strength of the light from behind.", {0, 20})
        .param("occlusion", &LightParams::occlusion,
               "Strength of the shade in corners and at contacts.", {0, 2})
        .colour("colour", &LightParams::colour, "Colour of the key light.")
        .choice("shadow", &LightParams::shadow, {"off", "low", "medium", "high"},
                "Fineness of the key light's shadow: none, or 512, 1024 or 2048 squared texels.");
}

inline void describe(graph::ParamsOf<GroundParams>& p)
{
    p.choice(
         "kind", &GroundParams::kind, {"none", "under", "at"},
         "The floor: `none`, `under` the stage (on a linked level collider where there is one), or "
         "`at` a height.")
        .param("height", &GroundParams::height, "Height of the floor.", {.unit = "m"},
               {"kind", {"at"}})
        .param("grid", &GroundParams::grid,
               "Lines on the floor a power of ten metres apart, every tenth one stronger.")
        .colour("colour", &GroundParams::colour, "Colour of the floor.");
}

inline void describe(graph::ParamsOf<BackdropParams>& p)
{
    p.colour("top", &BackdropParams::top, "Colour of the backdrop overhead.")
        .colour("horizon", &BackdropParams::horizon,
                "Colour of the backdrop at the horizon, into which the floor fades.");
}

inline constexpr const char* rest_told =
    "Mesh that sets the stage: the camera, the floor and the shadow are fitted to its bounds. Link "
    "what does not move (the mesh at rest), so that they stand still; without it they follow what "
    "is drawn.";
inline constexpr const char* view_told = "Camera of a file, from ReadCamera: then nothing of "
                                         "`camera` has effect but `views`, and `margin` "
                                         "and `hold` of the parallel ones of four.";

// The same camera with its target in the middle of the stage's depth, by which the floor's grid is
// laid out.
inline ::render::Camera aimed_at(::render::Camera camera, const geometry::Box& stage)
{
    if (stage.empty() || camera.field_of_view == ::render::parallel_view) return camera;
    const Vec3 ahead = (camera.target - camera.eye).normalized();
    const double depth = ahead.dot(stage.centre() - camera.eye);
    camera.target = camera.eye + std::max(depth, 0.1 * stage.diagonal()) * ahead;
    return camera;
}

inline constexpr const char* shot_told =
    "Points that set the stage instead of `rest`: link those of MotionBounds, so that the camera, "
    "the floor and the shadow hold the motion of all cooked frames.";
inline constexpr const char* quality_told =
    "draft: one sample per pixel, hard shadows, no shade in corners. preview: one sample, and a "
    "filter over the edges. standard: four samples per pixel where something changes; lines of a "
    "fifth of a pixel and more stay whole. final: the mean of 16 pictures, thinner lines too.";
inline constexpr const char* linear_told =
    "Whether the picture also has linear light, before tone mapping and without legend and label: "
    "WriteImage puts it into EXR files. whole: as it is seen, alpha 1. cut_out: without the "
    "backdrop; alpha is the share of a pixel that things and the floor cover. The edge filter of "
    "preview does not reach it.";

}  // namespace nodes::render
