#include "render/trace_fields.hpp"

#include "geometry/base/parallel.hpp"
#include "render/ray_picture.hpp"
#include "render/sample_places.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace render {
namespace {

constexpr std::size_t pixel_grain = 4096;

// Where an uneven pixel's samples lie: where the renderer will ask for them.
std::vector<PixelPlace> places_of(const Look& look, bool some_clear)
{
    std::vector<PixelPlace> places;
    const auto add = [&](const SamplePlace& p) { places.push_back({double(p.x), double(p.y)}); };
    if (look.antialias == Antialias::samples16) {
        for (int k = 0; k < lattice_samples; ++k) add(in_a_lattice(k));
    } else if (look.antialias == Antialias::samples4 && some_clear) {
        for (const SamplePlace& p : in_quarters) add(p);
    } else if (look.antialias == Antialias::samples4 && look.style != Style::diagram) {
        for (const SamplePlace& p : in_a_square) add(p);
    }
    return places;
}

// Rays whose t is the depth along the view, stage units.
RayGrid grid_of(const DrawList& list)
{
    const double metres = 1 / list.units.scale;
    RayGrid grid;
    grid.origin = list.units.centre + metres * list.view.eye.cast<double>();
    grid.along = metres * list.view.corner.cast<double>();
    grid.across = metres * list.view.across.cast<double>();
    grid.down = metres * list.view.down.cast<double>();
    grid.begin = static_cast<double>(list.view.near);
    return grid;
}

std::uint32_t step_of(double x, double most)
{
    return static_cast<std::uint32_t>(std::lround(most * std::clamp(x, 0.0, 1.0)));
}

// As pack_pixel() in shaders/pack.glsl.
std::uint32_t packed_normal(const Vec3f& normal)
{
    const Vec3 n = normal.cast<double>() / normal.cast<double>().cwiseAbs().sum();
    double x = n.x(), y = n.y();
    if (n.z() < 0) {
        x = std::copysign(1 - std::abs(n.y()), n.x());
        y = std::copysign(1 - std::abs(n.x()), n.y());
    }
    return step_of(0.5 * x + 0.5, 16383) | step_of(0.5 * y + 0.5, 16383) << 14;
}

std::uint32_t packed_colour(const Vec3f& linear, float roughness)
{
    std::uint32_t packed = step_of(static_cast<double>(roughness), 255) << 24;
    for (int k = 0; k < 3; ++k) {
        packed |= step_of(std::sqrt(std::max(0.0, static_cast<double>(linear[k]))), 255) << (8 * k);
    }
    return packed;
}

// Turns hits into what the first pass stores.
class Packer {
public:
    Packer(const Scene& scene, const DrawList& list, const RayGrid& grid)
        : scene_(scene), grid_(grid), near_(static_cast<double>(list.view.near)),
          far_(static_cast<double>(list.view.far))
    {
        for (const FieldSurface& f : scene.fields) {
            const Vec3f& colour =
                f.paint.by == Paint::By::constant ? f.paint.colour : f.material.colour;
            colours_.push_back(packed_colour(colour, f.material.roughness));
            const std::uint32_t metal = step_of(static_cast<double>(f.material.metallic), 7);
            others_.push_back(metal << 28 | 1u << 31);
        }
    }

    TracedPixel operator()(const SurfaceHit& hit, double x, double y) const
    {
        TracedPixel pixel;
        if (hit.surface < 0) return pixel;
        const auto s = static_cast<std::size_t>(hit.surface);
        const FieldSurface& f = scene_.fields[s];
        pixel.colour = colours_[s];
        if (f.paint.by == Paint::By::attribute) {
            const geometry::Ray ray = grid_.ray(x, y);
            const double value = f.value(ray.origin + hit.t * ray.direction);
            const float place = f.paint.scale.place(static_cast<float>(value));
            pixel.colour = packed_colour(linear_from_srgb(colour_at(f.paint.scale.map, place)),
                                         f.material.roughness);
        }
        pixel.normal = packed_normal(hit.normal) | others_[s];
        // Reversed: 1 at `near`, 0 at `far`.
        const double depth = near_ / (far_ - near_) * (far_ / hit.t - 1);
        pixel.depth = static_cast<float>(std::clamp(depth, 1e-9, 1.0));
        return pixel;
    }

private:
    const Scene& scene_;
    const RayGrid& grid_;
    double near_, far_;
    std::vector<std::uint32_t> colours_, others_;
};

void trace_view(const Scene& scene, const Look& look, DrawList& list)
{
    const std::vector<PixelPlace> places = places_of(look, !list.clear.empty());
    const RayGrid grid = grid_of(list);
    const double tolerance = 2e-7 / list.units.scale;
    const RayPicture found =
        ray_picture(scene.fields, grid, look.width, look.height, places, tolerance);
    Traced& traced = list.traced;
    traced.x = found.x;
    traced.y = found.y;
    traced.width = found.width;
    traced.height = found.height;
    traced.places = static_cast<int>(places.size());
    traced.pixels.resize(found.hits.size());
    traced.samples.resize(found.samples.size());
    const Packer pack(scene, list, grid);
    const auto width = static_cast<std::size_t>(std::max(1, found.width));
    geometry::parallel_for(found.hits.size(), pixel_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double x = found.x + static_cast<double>(i % width) + 0.5;
            const std::size_t row = i / width;
            const double y = found.y + static_cast<double>(row) + 0.5;
            traced.pixels[i] = pack(found.hits[i], x, y);
            traced.pixels[i].fine = found.fine[i];
            for (std::size_t k = 0; found.fine[i] > 0 && k < places.size(); ++k) {
                const std::size_t at = found.fine[i] - 1 + k;
                traced.samples[at] = pack(found.samples[at], x + places[k][0], y + places[k][1]);
            }
        }
    });
}

// What is stored for the texel (x, y) of the shadow map: as polygons are, a little deeper than the
// surface, by how steep it is.
float shadow_depth(const RayGrid& grid, const SurfaceHit& hit, double steepest, double t)
{
    const Vec3 n = hit.normal.cast<double>();
    const double along = std::max(std::abs(n.dot(grid.along)), 1e-300);
    const double slope = std::max(std::abs(n.dot(grid.across)), std::abs(n.dot(grid.down))) / along;
    return static_cast<float>(std::clamp(t + 1.5 * std::min(slope, steepest), 0.0, 1.0));
}

void trace_shadow(const Scene& scene, DrawList& list)
{
    const ShadowMap& map = list.shadow;
    if (map.width == 0) return;
    // Squares of 2 x 2 texels, whose plane tells all four where it continues.
    constexpr int side = 2;
    const Eigen::Matrix4d from = map.from_stage.cast<double>();
    const geometry::Mat3 inverse = from.topLeftCorner<3, 3>().inverse();
    const Vec3 corner = -inverse * from.topRightCorner<3, 1>();
    const double metres = 1 / list.units.scale;
    RayGrid grid;
    grid.parallel = true;
    grid.begin = -std::numeric_limits<double>::infinity();
    grid.origin = list.units.centre + metres * corner;
    grid.across = metres * side / map.width * inverse.col(0);
    grid.down = metres * side / map.height * inverse.col(1);
    grid.along = metres * inverse.col(2);
    std::vector<PixelPlace> places;
    for (const SamplePlace& p : in_quarters) places.push_back({double(p.x), double(p.y)});
    const double tolerance = 0.02 * static_cast<double>(map.texel) * metres;
    const RayPicture found = ray_picture(scene.fields, grid, (map.width + side - 1) / side,
                                         (map.height + side - 1) / side, places, tolerance, true);
    const double steepest = 6 * grid.across.norm() / grid.along.norm();
    RayGrid texels = grid;  // slopes are per texel
    texels.across /= side;
    texels.down /= side;
    Traced& traced = list.traced;
    traced.shadow_x = side * found.x;
    traced.shadow_y = side * found.y;
    traced.shadow_width = side * found.width;
    traced.shadow_height = side * found.height;
    traced.shadow.assign(found.hits.size() * side * side, 2);
    const auto width = static_cast<std::size_t>(std::max(1, found.width));
    geometry::parallel_for(found.hits.size(), pixel_grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double x = found.x + static_cast<double>(i % width) + 0.5;
            const std::size_t line = i / width;
            const double y = found.y + static_cast<double>(line) + 0.5;
            for (std::size_t k = 0; k < places.size(); ++k) {
                const bool fine = found.fine[i] > 0;
                const SurfaceHit& hit = fine ? found.samples[found.fine[i] - 1 + k] : found.hits[i];
                if (hit.surface < 0) continue;
                const double t =
                    fine ? hit.t : on_plane(grid, hit, x, y, x + places[k][0], y + places[k][1]);
                const std::size_t column = side * (i % width) + k % side;
                const std::size_t row = side * line + k / side;
                traced.shadow[row * side * width + column] = shadow_depth(texels, hit, steepest, t);
            }
        }
    });
}

}  // namespace

void trace_fields(const Scene& scene, const Look& look, DrawList& list)
{
    if (scene.fields.empty()) return;
    for (const FieldSurface& f : scene.fields) {
        if (f.paint.by != Paint::By::attribute || f.paint.attribute == f.attribute) continue;
        throw std::invalid_argument("the layers are to be coloured by `" + f.paint.attribute +
                                    "`, which they do not have; they have " +
                                    (f.attribute.empty() ? "no attributes" : f.attribute));
    }
    trace_view(scene, look, list);
    trace_shadow(scene, list);
}

}  // namespace render
