#include "render/draw_job.hpp"

#include <algorithm>
#include <cmath>

namespace render {
namespace {

constexpr float occlusion_reach = 0.8f;  // stage units, of what may keep light from a place

FrameNumbers::Vec4 with(const Vec3f& v, float fourth)
{
    return {v[0], v[1], v[2], fourth};
}

FrameNumbers::Mat4 columns(const Eigen::Matrix4f& m)
{
    FrameNumbers::Mat4 out;
    std::copy_n(m.data(), out.size(), out.begin());
    return out;
}

// From behind what is seen and a little above, on the side that the key light leaves dark.
Vec3f to_rim(const DrawList& list)
{
    const Vec3f right = list.view.across.normalized(), up = -list.view.down.normalized();
    const Vec3f ahead = up.cross(right);
    return (0.9f * ahead + 0.5f * up - 0.8f * list.to_light.dot(right) * right).normalized();
}

FrameNumbers numbers_of(const DrawList& list, const Look& look)
{
    FrameNumbers f{};
    const View& view = list.view;
    const bool shadow = list.shadow.width > 0;
    f.clip_from_stage = columns(view.clip_from_stage);
    if (shadow) f.shadow_from_stage = columns(list.shadow.from_stage);
    f.units = with(list.units.centre.cast<float>(), float(list.units.scale));
    f.eye = with(view.eye, view.near);
    f.corner = with(view.corner, view.far);
    f.across = with(view.across, float(look.width));
    f.down = with(view.down, float(look.height));
    f.to_light = with(list.to_light, shadow ? 1 : 0);
    f.light = with(look.light, list.shadow.texel);
    f.sky = with(look.sky, list.ground ? 1 : 0);
    f.bounce = with(look.bounce, list.ground.value_or(0));
    f.backdrop_top = with(look.backdrop_top, look.grid ? list.grid_spacing : 0);
    f.backdrop_horizon = with(look.backdrop_horizon, look.glass && !list.clear.empty() ? 1 : 0);
    f.floor_colour = with(look.floor, 1);
    const double period = 10.0 * list.grid_spacing;
    const auto on_grid = [&](double centre) {
        return period > 0 ? float(std::remainder(centre * list.units.scale, period)) : 0;
    };
    f.shadow_size = {float(list.shadow.width), float(list.shadow.height),
                     on_grid(list.units.centre.x()), on_grid(list.units.centre.z())};
    f.soft = {float(std::tan(0.5 * look.light_size)), list.shadow.depth, float(look.occlusion),
              occlusion_reach};
    f.rim = with(to_rim(list), float(look.rim));
    const ShadowMap& far = list.far_shadow;
    if (far.width > 0) {
        f.far_from_stage = columns(far.from_stage);
        f.far_size = {float(far.width), float(far.height), far.texel, 0};
    }
    if (!list.drawn.empty()) {
        f.drawn_low = with(list.drawn.lo.cast<float>(), 0);
        f.drawn_high = with(list.drawn.hi.cast<float>(), 0);
    }
    return f;
}

FloorPiece piece_of(const std::vector<Vec3f>& corners)
{
    FloorPiece piece;
    piece.there = !corners.empty();
    if (piece.there) std::copy_n(corners[0].data(), piece.corners.size(), piece.corners.begin());
    return piece;
}

}  // namespace

DrawJob draw_job(const DrawList& list, const Look& look)
{
    DrawJob job;
    job.numbers.width = look.width;
    job.numbers.height = look.height;
    job.numbers.samples4 = look.antialias == Antialias::samples4;
    job.numbers.pictures = look.antialias == Antialias::samples16 ? 16 : 1;
    job.numbers.style = look.style;
    job.numbers.linear = look.linear;
    job.numbers.layered = static_cast<std::uint32_t>(list.layered);
    job.numbers.soft = look.soft;
    job.numbers.shadow_width = list.shadow.width;
    job.numbers.shadow_height = list.shadow.height;
    job.numbers.far_width = list.far_shadow.width;
    job.numbers.far_height = list.far_shadow.height;
    job.numbers.floor = piece_of(list.floor);
    job.numbers.shadowed_floor = piece_of(list.shadowed_floor);
    job.numbers.frame = numbers_of(list, look);
    job.vertices = list.vertices;
    job.indices = list.indices;
    job.opaque = list.opaque;
    job.clear = list.clear;
    job.uvs = list.uvs;
    const Traced& traced = list.traced;
    job.numbers.traced = {traced.x, traced.y, traced.width, traced.height};
    job.numbers.traced_shadow = {traced.shadow_x, traced.shadow_y, traced.shadow_width,
                                 traced.shadow_height};
    job.traced = traced.pixels;
    job.traced_samples = traced.samples;
    job.traced_shadow = traced.shadow;
    for (const DrawnTexture& t : list.textures) {
        const geometry::Picture& picture = t.texture->picture();
        job.textures.push_back({t.texture->digest() + (t.normals ? 1 : 0), picture.width,
                                picture.height, t.normals, picture.rgba.data()});
    }
    return job;
}

}  // namespace render
