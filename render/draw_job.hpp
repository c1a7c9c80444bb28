#pragma once

// One picture as plain data: what OpenGL is handed, in this process or in another. Everything has
// been computed already; only triangles, lines and balls are left to fill in.

#include "render/draw_list.hpp"
#include "render/look.hpp"

#include <array>
#include <span>
#include <type_traits>

namespace render {

// As in shaders/frame.glsl: each member is a mat4 (columns) or a vec4.
struct FrameNumbers {
    using Mat4 = std::array<float, 16>;
    using Vec4 = std::array<float, 4>;
    Mat4 clip_from_stage, shadow_from_stage;
    Vec4 units, eye, corner, across, down, to_light, light, sky, bounce, backdrop_top,
        backdrop_horizon, floor_colour, shadow_size, soft, rim, drawn_low, drawn_high;
    Mat4 far_from_stage;
    Vec4 far_size;
};
static_assert(sizeof(FrameNumbers) == (3 * 16 + 18 * 4) * sizeof(float));

// Corners of a triangle strip, stage units.
struct FloorPiece {
    bool there = false;
    std::array<float, 12> corners{};
};

struct PictureNumbers {
    int width = 0, height = 0;
    bool samples4 = false;  // four samples a pixel where something changes
    int pictures = 1;       // to take the mean of, each with other samples
    int only = -1;          // one of those sixteen by itself, where `pictures` is 1; -1: none
    Style style = Style::plain;
    Linear linear = Linear::none;
    std::uint32_t layered = 0;                // batches, see DrawList; 0: nothing is peeled
    bool soft = false;                        // soft shadows and shade in corners
    int shadow_width = 0, shadow_height = 0;  // texels; 0: there is no shadow
    int far_width = 0, far_height = 0;        // of the coarser map of what the first does not reach
    FloorPiece floor, shadowed_floor;
    // Parts of the picture and of its shadow map that rays have told of; see Traced.
    std::array<int, 4> traced{}, traced_shadow{};
    FrameNumbers frame{};
};
static_assert(std::is_trivially_copyable_v<PictureNumbers>);
static_assert(std::is_trivially_copyable_v<Vertex> && std::is_trivially_copyable_v<Batch>);

// A texture; `rgba` is null where the process that draws has it already.
struct JobTexture {
    std::uint64_t digest = 0;  // the same for equal pictures that are used alike
    int width = 0, height = 0;
    bool normals = false;  // else colours
    const std::uint8_t* rgba = nullptr;

    std::size_t bytes() const { return 4 * std::size_t(width) * std::size_t(height); }
};

// The spans belong to the draw list, or to memory that two processes share.
struct DrawJob {
    PictureNumbers numbers;
    std::span<const Vertex> vertices;
    std::span<const std::uint32_t> indices;
    std::span<const std::array<float, 2>> uvs;  // of the vertices; empty without textures
    std::span<const Batch> opaque, clear;
    std::span<const TracedPixel> traced, traced_samples;
    std::span<const float> traced_shadow;
    std::vector<JobTexture> textures;
};

// Where the pixels of a job go, rows from the top.
struct Pixels {
    std::span<std::uint8_t> rgba;  // width * height * 4
    std::span<float> linear = {};  // linear_floats(), where the job asks for light
};

// Four for the light of a pixel, premultiplied with alpha; then, for all pixels, one for the depth
// of what is nearest there, m: `nothing_there` where nothing is.
inline std::size_t linear_floats(const PictureNumbers& n)
{
    return n.linear == Linear::none ? 0 : 5 * std::size_t(n.width) * std::size_t(n.height);
}

DrawJob draw_job(const DrawList& list, const Look& look);

}  // namespace render
