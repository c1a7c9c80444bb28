#include "render/make_draw_list.hpp"

#include "geometry/base/parallel.hpp"
#include "render/gather.hpp"
#include "render/trace_fields.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace render {
namespace {

constexpr std::size_t box_grain = 8192;
constexpr double caster_reach = 3;        // stage units, see box_along
constexpr double far_widths = 6;          // likewise, widths of what is seen at the stage
constexpr double widest_penumbra = 0.06;  // stage units, half of it; of shaders/seen.frag
constexpr float floor_reach = 9;          // stage units, FLOOR_REACH of shaders/frame.glsl

// The box of all drawn points in the basis `axes` (rows), stage units. With a `reach` only of what
// casts a shadow, and is no farther from the stage's centre: the shadow of the rest stays as fine
// as it is.
Box box_along(const DrawList& list, const geometry::Mat3& axes, std::optional<double> reach)
{
    const bool only_casters = reach.has_value();
    const double reach_sq = only_casters ? *reach * *reach : 0;
    std::vector<Box> parts;
    for (const auto* batches : {&list.opaque, &list.clear}) {
        for (const Batch& batch : *batches) {
            if (only_casters && !batch.shadow) continue;
            const std::size_t pieces = (batch.count + box_grain - 1) / box_grain;
            const std::size_t at = parts.size();
            parts.resize(at + pieces);
            geometry::parallel_for(pieces, 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t piece = begin; piece < end; ++piece) {
                    const std::size_t stop =
                        std::min<std::size_t>(batch.count, (piece + 1) * box_grain);
                    Box box;
                    for (std::size_t i = piece * box_grain; i < stop; ++i) {
                        const auto& v = list.vertices[list.indices[batch.first + i]];
                        const Vec3 q = list.units(Vec3f(v.position.data()).cast<double>());
                        if (only_casters && q.squaredNorm() > reach_sq) continue;
                        const Vec3 p = axes * q;
                        if (batch.shape == Batch::Shape::balls) {
                            const Vec3 r = Vec3::Constant(v.value * list.units.scale);
                            box.add(Vec3(p - r));
                            box.add(Vec3(p + r));
                        } else {
                            box.add(p);
                        }
                    }
                    parts[at + piece] = box;
                }
            });
        }
    }
    Box box;
    for (const Box& part : parts) {
        if (!part.empty()) box.add(part);
    }
    for (const Box& field : list.field_bounds) {
        for (int k = 0; k < 8; ++k) box.add(Vec3(axes * list.units(corner_of(field, k))));
    }
    return box;
}

// Grows `box` about its centre, an axis at a time, by steps of a quarter until it holds `inside`:
// what moves inside a step changes nothing, so that a shadow does not crawl from frame to frame.
Box grown_to_hold(Box box, const Box& inside)
{
    if (inside.empty()) return box;
    for (int k = 0; k < 3; ++k) {
        const double middle = 0.5 * (box.lo[k] + box.hi[k]);
        double half = std::max(0.5 * (box.hi[k] - box.lo[k]), 1e-3);
        const double needed = std::max(inside.hi[k] - middle, middle - inside.lo[k]);
        while (half < needed) half *= 1.25;
        box.lo[k] = middle - half;
        box.hi[k] = middle + half;
    }
    return box;
}

geometry::Mat3 light_axes(const Vec3& to_light)
{
    const Vec3 side =
        std::abs(to_light.y()) > 0.999 ? Vec3(1, 0, 0) : Vec3(0, 1, 0).cross(to_light).normalized();
    geometry::Mat3 axes;
    axes.row(0) = side;
    axes.row(1) = to_light.cross(side);
    axes.row(2) = -to_light;
    return axes;
}

// The part of the floor at `height` that lies behind `casters`, a box along the light's axes. Along
// the light it is cut off where the floor has faded away.
std::vector<Vec3f> shadowed_floor(const geometry::Mat3& axes, const Box& casters, double height)
{
    const Vec3 along = axes.row(2);
    const double farthest = 2 * double(floor_reach) / std::hypot(along.x(), along.z());
    std::vector<Vec3f> corners;
    for (int k = 0; k < 4; ++k) {
        const Vec3 p = axes.transpose() * Vec3(k & 1 ? casters.hi.x() : casters.lo.x(),
                                               k & 2 ? casters.hi.y() : casters.lo.y(), 0);
        const double step = std::clamp((height - p.y()) / along.y(), -farthest, farthest);
        const Vec3 at = p + step * along;
        corners.emplace_back(float(at.x()), float(height), float(at.z()));
    }
    return corners;
}

constexpr double rim = 6;  // texels of a map left free, for the filter

// Texels along the side of a square map.
int side_of(const Look& look)
{
    return look.shadow == ShadowQuality::low      ? 512
           : look.shadow == ShadowQuality::medium ? 1024
                                                  : 2048;
}

// Square texels, as many as the quality affords however long and thin the box is. Stage units.
double texel_of(const Vec3& size, const Look& look)
{
    const int side = side_of(look);
    const double limit = 4.0 * side;
    return std::max(std::sqrt(size.x() * size.y()) / side,
                    std::max(size.x(), size.y()) / (limit - 2 * rim));
}

Vec3 size_of(const Box& box)
{
    return box.size().cwiseMax(Vec3::Constant(1e-2));
}

// The map of what lies in `box`, along the light's `axes`.
ShadowMap map_of(const Box& box, const geometry::Mat3& axes, const Look& look)
{
    const Vec3 size = size_of(box);
    const double texel = texel_of(size, look);
    ShadowMap map;
    map.width = static_cast<int>(std::ceil(size.x() / texel + 2 * rim));
    map.height = static_cast<int>(std::ceil(size.y() / texel + 2 * rim));
    map.texel = static_cast<float>(texel);
    map.depth = static_cast<float>(0.98 / size.z());

    const Vec3 centre = box.centre();
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    const Vec3 scale(1 / (texel * map.width), 1 / (texel * map.height), 0.98 / size.z());
    for (int k = 0; k < 3; ++k) {
        m.block<1, 3>(k, 0) = scale[k] * axes.row(k);
        m(k, 3) = 0.5 - scale[k] * centre[k];
    }
    map.from_stage = m.cast<float>();
    return map;
}

bool holds(const Box& box, const Box& inside)
{
    return (box.lo.array() <= inside.lo.array()).all() &&
           (box.hi.array() >= inside.hi.array()).all();
}

// How far from the stage things cast shadows: as far as the floor goes, and farther where the
// picture shows more. Not by what is seen of them: a camera that turns about does not change it.
double far_reach(const Camera& camera, const DrawList& list, const Look& look)
{
    const double aspect = std::max(1.0, double(look.width) / look.height);
    const double seen =
        2 * std::tan(camera.field_of_view / 2) * aspect * list.units(camera.eye).norm();
    return std::clamp(far_widths * seen, double(floor_reach), 1e4);
}

void fit_shadows(DrawList& list, const Vec3& to_light, const Box& stage, const Camera& camera,
                 const Look& look)
{
    if (look.shadow == ShadowQuality::off) return;
    const geometry::Mat3 axes = light_axes(to_light);
    Box casters = box_along(list, axes, caster_reach);
    Box about_stage;
    for (int k = 0; k < 8; ++k) {
        about_stage.add(Vec3(axes * list.units(corner_of(stage, k))));
    }
    const Box box = grown_to_hold(about_stage, casters);
    const double farthest = list.drawn.lo.cwiseAbs().cwiseMax(list.drawn.hi.cwiseAbs()).norm();
    if (farthest > caster_reach) {
        const Box all = box_along(list, axes, far_reach(camera, list, look));
        if (!all.empty() && !holds(box, all)) {
            list.far_shadow = map_of(grown_to_hold(box, all), axes, look);
            casters = box;  // what is far away lies over all of the near map
        }
    }
    if (casters.empty()) return;
    list.shadow = map_of(box, axes, look);
    if (list.ground && to_light.y() > 0.01) {
        const double apart =
            std::max(rim * texel_of(size_of(box), look), look.soft ? widest_penumbra : 0);
        const Vec3 rim_size(apart, apart, 0);
        list.shadowed_floor =
            shadowed_floor(axes, {casters.lo - rim_size, casters.hi + rim_size}, *list.ground);
    }
}

View view_of(const Camera& camera, const DrawList& list, const Look& look)
{
    const Vec3 eye = list.units(camera.eye), target = list.units(camera.target);
    const Vec3 ahead = target - eye;
    if (!eye.allFinite() || !ahead.allFinite() || ahead.norm() == 0) {
        throw std::invalid_argument(
            "the camera must stand at a finite place other than its target");
    }
    const double fov = camera.field_of_view;
    if (!(fov > 1e-3 && fov < 3.1)) {
        throw std::invalid_argument("the camera's field of view must lie between 0.06 and 177 "
                                    "degrees, got " +
                                    std::to_string(fov * 180 / 3.141592653589793));
    }
    const geometry::Mat3 axes = camera_axes(camera);
    const Vec3 right = axes.row(0), up = axes.row(1), forward = axes.row(2);
    const Box box = box_along(list, axes, std::nullopt);
    const double eye_depth = forward.dot(eye);
    double far = box.empty() ? 2 : 1.01 * (box.hi.z() - eye_depth) + 1e-3;
    far = std::max(far, 1e-3);
    double near = box.empty() ? 1 : 0.99 * (box.lo.z() - eye_depth) - 1e-3;
    for (const Vec3f& corner : list.floor) {
        far = std::max(far, 1.01 * (forward.dot(corner.cast<double>()) - eye_depth));
        near = std::min(near, 0.01);
    }
    near = std::max(near, 1e-4 * far);

    const double tan_y = std::tan(fov / 2), tan_x = tan_y * look.width / look.height;
    // Depth runs from 1 at `near` to 0 at `far`: floating-point depths are then even in error.
    Eigen::Matrix4d clip = Eigen::Matrix4d::Zero();
    clip(0, 0) = 1 / tan_x;
    clip(1, 1) = -1 / tan_y;  // pictures have their first row on top
    clip(2, 2) = -near / (far - near);
    clip(2, 3) = near * far / (far - near);
    clip(3, 2) = 1;
    Eigen::Matrix4d turn = Eigen::Matrix4d::Identity();
    turn.topLeftCorner<3, 3>() = axes;
    turn.topRightCorner<3, 1>() = -(axes * eye);

    View view;
    view.clip_from_stage = (clip * turn).cast<float>();
    view.eye = eye.cast<float>();
    view.corner = (forward - tan_x * right + tan_y * up).cast<float>();
    view.across = (2 * tan_x / look.width * right).cast<float>();
    view.down = (-2 * tan_y / look.height * up).cast<float>();
    view.near = static_cast<float>(near);
    view.far = static_cast<float>(far);
    return view;
}

void check(const Scene& scene, const Look& look)
{
    if (look.width < 1 || look.height < 1 || look.width > 8192 || look.height > 8192) {
        throw std::invalid_argument("a picture must be 1 to 8192 pixels wide and high, got " +
                                    std::to_string(look.width) + " x " +
                                    std::to_string(look.height));
    }
    for (const Surface& s : scene.surfaces) {
        if (!s.mesh) throw std::invalid_argument("a surface to be drawn has no mesh");
    }
}

}  // namespace

DrawList make_draw_list(const Scene& scene, const Camera& camera, const Look& look)
{
    check(scene, look);
    DrawList list;
    Box stage = scene.stage.empty() ? bounds(scene) : scene.stage;
    if (stage.empty()) stage.add(Vec3(Vec3::Zero()));
    if (!(stage.diagonal() > 1e-12 * std::max(1.0, stage.centre().cwiseAbs().maxCoeff()))) {
        stage.lo.array() -= 0.5;
        stage.hi.array() += 0.5;
    }
    if (!std::isfinite(stage.diagonal())) {
        throw std::invalid_argument("the stage to be drawn is not finite");
    }
    list.units = {stage.centre(), 2 / stage.diagonal()};

    Gathering all = start_gathering(list, camera.eye - camera.target);
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) add_surface(all, scene.surfaces[i], i);
    for (const Lines& lines : scene.lines) add_lines(all, lines);
    for (const Balls& balls : scene.balls) add_balls(all, balls);
    finish_gathering(all);
    for (const FieldSurface& field : scene.fields) {
        if (!field.extent.empty()) list.field_bounds.push_back(field.extent);
    }

    const Vec3 to_light = direction(look.light_azimuth, look.light_elevation);
    list.to_light = to_light.cast<float>();
    // From below the floor one looks through it.
    const double eye_height = list.units(camera.eye).y();
    if (scene.ground && list.units(Vec3(0, *scene.ground, 0)).y() < eye_height) {
        list.ground = static_cast<float>(list.units(Vec3(0, *scene.ground, 0)).y());
        // Fine lines a tenth of the spacing apart, by what the picture holds at its target: they
        // stay as they are while the camera does, whatever flies about.
        const double height = 2 * std::tan(0.5 * camera.field_of_view) *
                              std::max((camera.eye - camera.target).norm(), 1e-9);
        const double spacing = std::pow(10, std::floor(std::log10(0.27 * height)));
        list.grid_spacing = static_cast<float>(spacing * list.units.scale);
        for (int k = 0; k < 4; ++k) {
            list.floor.emplace_back(k & 1 ? floor_reach : -floor_reach, *list.ground,
                                    k & 2 ? floor_reach : -floor_reach);
        }
    }
    list.drawn = box_along(list, geometry::Mat3::Identity(), std::nullopt);
    fit_shadows(list, to_light, stage, camera, look);
    list.view = view_of(camera, list, look);
    trace_fields(scene, look, list);
    return list;
}

}  // namespace render
