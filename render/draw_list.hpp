#pragma once

// A scene made ready for a drawing backend: one array of vertices, one of indices, a few batches,
// and the numbers of the camera and the light. No OpenGL here: what is drawn, and in which order,
// is decided without it.
//
//   scene -- make_draw_list --> DrawList -- Renderer --> image
//              (gather)

#include "geometry/mesh/texture.hpp"
#include "render/colour.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace render {

using geometry::Box;
using geometry::Vec3;

// As the graphics memory has it.
struct Vertex {
    std::array<float, 3> position;
    std::array<std::int16_t, 2> normal;    // octahedral, see gather.cpp
    std::array<std::uint8_t, 4> colour;    // square roots of linear RGB, and roughness
    std::array<std::uint8_t, 4> material;  // metallic, opacity, 255 when lit, 0
    float value;                           // place in the colour map; a ball's radius
};
static_assert(sizeof(Vertex) == 28);

// The pictures that faces are covered with.
struct Cover {
    std::int32_t texture = -1;  // into DrawList::textures; -1: none
    std::int32_t normals = -1;  // likewise, a normal map
    float bump = 1;             // see geometry::Material
    bool colours = false;       // the picture times the vertices' colour; else its alpha alone
    geometry::TextureUse use;

    bool any() const { return texture >= 0 || normals >= 0; }
};

struct Batch {
    enum class Shape { triangles, lines, balls } shape = Shape::triangles;
    std::uint32_t first = 0, count = 0;  // indices
    bool mapped = false;                 // colour by value through `map`
    ColourMap map = ColourMap::viridis;
    bool shadow = true;
    bool body = false, ghost = false;  // see Surface::Kind
    float size = 1;                    // pixels: width of lines, least diameter of balls
    Cover cover;
};

// Pictures are computed in stage units: the stage's centre is the origin and half its diagonal is
// 1, so that millimetres and kilometres meet the same rounding.
struct StageUnits {
    Vec3 centre{0, 0, 0};
    double scale = 1;  // stage units per metre

    Vec3 operator()(const Vec3& world) const { return scale * (world - centre); }
};

// Of the camera, in stage units: a point at depth z along the view lies on
// eye + z * (corner + x * across + y * down), x and y in pixels from the upper left corner.
struct View {
    Eigen::Matrix4f clip_from_stage;
    Vec3f eye, corner, across, down;
    float near = 0, far = 0;
};

// A map of the depths that the key light sees.
struct ShadowMap {
    int width = 0, height = 0;   // texels; 0: there is no shadow
    Eigen::Matrix4f from_stage;  // to 0..1 in x, y and depth
    float texel = 0;             // stage units
    float depth = 1;             // of the map's depth, for each stage unit
};

// What a ray found of a surface without triangles, as the first pass stores it (shaders/pack.glsl).
struct TracedPixel {
    std::uint32_t colour = 0, normal = 0;
    float depth = 0;  // as in the depth buffer, 1 near; 0: nothing is there
    std::uint32_t fine =
        0;  // 1 + where the pixel's own samples begin; 0: it has none, it is a plane
};
static_assert(sizeof(TracedPixel) == 16);

// What rays found of all such surfaces, in a part of the picture and of the shadow map.
struct Traced {
    int x = 0, y = 0, width = 0, height = 0;  // pixels
    int places = 0;                           // samples of a pixel that has some
    std::vector<TracedPixel> pixels;          // width * height
    std::vector<TracedPixel> samples;
    int shadow_x = 0, shadow_y = 0, shadow_width = 0, shadow_height = 0;  // texels
    std::vector<float> shadow;  // shadow_width * shadow_height, depths; above 1: nothing
};

struct DrawnTexture {
    std::shared_ptr<const geometry::Texture> texture;
    bool normals = false;  // else colours
};

struct DrawList {
    std::vector<Vertex> vertices;
    std::vector<std::array<float, 2>> uvs;  // of the vertices, v up; empty without textures
    std::vector<std::uint32_t> indices;
    std::vector<DrawnTexture> textures;
    std::vector<Batch> opaque;
    // Far to near. Where they may cut through each other, the first `layered` batches are all of
    // them in the order of the scene, for layers.
    std::vector<Batch> clear;
    std::size_t layered = 0;
    std::vector<Box> field_bounds;  // m, of surfaces without triangles; they cast shadows
    Traced traced;
    StageUnits units;
    View view;
    // The first holds what is near the stage. What it does not reach is in a coarser one, where
    // there is anything: of no width otherwise.
    ShadowMap shadow, far_shadow;
    Vec3f to_light;
    std::optional<float> ground;  // stage units
    // Corners of the floor, and of the part of it that a shadow may fall on, in the order of a
    // triangle strip. Stage units; empty without a floor, or without a shadow.
    std::vector<Vec3f> floor, shadowed_floor;
    Box drawn;               // what is drawn, stage units; empty when nothing is
    float grid_spacing = 0;  // stage units; a power of ten in metres
    std::vector<std::string> warnings;
};

}  // namespace render
