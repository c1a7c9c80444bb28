#include "render/ray_picture.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace render {
namespace {

using geometry::Ray;
using geometry::RayHit;
using geometry::Vec3i;

constexpr int tile_side = 16;

// Tiles in which each surface may be seen.
struct Tiles {
    int columns = 0, rows = 0;
    std::vector<std::vector<std::uint8_t>> may_see;  // a surface, then a tile
    std::vector<std::uint32_t> open;                 // tiles of any surface, ascending

    std::size_t count() const
    {
        return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    }
    int x_of(std::uint32_t tile) const { return static_cast<int>(tile) % columns * tile_side; }
    int y_of(std::uint32_t tile) const { return static_cast<int>(tile) / columns * tile_side; }
};

// From a place in the world to x, y and t of the ray through it.
struct Projection {
    explicit Projection(const RayGrid& grid) : origin(grid.origin), parallel(grid.parallel)
    {
        geometry::Mat3 m;
        m.col(0) = grid.across;
        m.col(1) = grid.down;
        m.col(2) = grid.along;
        inverse = m.inverse();
    }
    Vec3 operator()(const Vec3& p) const
    {
        const Vec3 v = inverse * (p - origin);
        return parallel ? v : Vec3(v.x() / v.z(), v.y() / v.z(), v.z());
    }
    Vec3 origin;
    geometry::Mat3 inverse;
    bool parallel;
};

// Marks the tiles that a box may be seen in.
void mark(const Projection& project, const RayGrid& grid, const Box& box, const Tiles& tiles,
          std::vector<std::uint8_t>& may_see)
{
    Box seen;
    bool behind = false;
    for (int k = 0; k < 8; ++k) {
        const Vec3 p = project({k & 1 ? box.hi.x() : box.lo.x(), k & 2 ? box.hi.y() : box.lo.y(),
                                k & 4 ? box.hi.z() : box.lo.z()});
        behind |= !grid.parallel && !(p.z() > grid.begin);
        seen.add(p);
    }
    if (!grid.parallel && seen.hi.z() < grid.begin) return;
    const auto tile = [](double pixel, int count) {
        return static_cast<int>(std::clamp(std::floor(pixel / tile_side), -1.0, double(count)));
    };
    const int left = behind ? 0 : std::max(0, tile(seen.lo.x(), tiles.columns));
    const int right =
        behind ? tiles.columns - 1 : std::min(tiles.columns - 1, tile(seen.hi.x(), tiles.columns));
    const int top = behind ? 0 : std::max(0, tile(seen.lo.y(), tiles.rows));
    const int bottom =
        behind ? tiles.rows - 1 : std::min(tiles.rows - 1, tile(seen.hi.y(), tiles.rows));
    for (int row = top; row <= bottom; ++row) {
        for (int column = left; column <= right; ++column) {
            may_see[static_cast<std::size_t>(column + row * tiles.columns)] = 1;
        }
    }
}

Tiles tiles_of(std::span<const FieldSurface> surfaces, const RayGrid& grid, int width, int height,
               bool casters)
{
    Tiles tiles;
    tiles.columns = (width + tile_side - 1) / tile_side;
    tiles.rows = (height + tile_side - 1) / tile_side;
    const Projection project(grid);
    std::vector<std::uint8_t> any(tiles.count(), 0);
    for (const FieldSurface& surface : surfaces) {
        auto& may_see = tiles.may_see.emplace_back(tiles.count(), std::uint8_t{0});
        if (casters && !surface.shadow) continue;
        const geometry::IsoCells& cells = surface.cells;
        for (int z = 0; z < cells.dims.z(); ++z) {
            for (int y = 0; y < cells.dims.y(); ++y) {
                for (int x = 0; x < cells.dims.x(); ++x) {
                    const Vec3i at(x, y, z);
                    if (!(cells.slope[cells.index(at)] > 0)) continue;
                    mark(project, grid, cells.box(at), tiles, may_see);
                }
            }
        }
        for (std::size_t i = 0; i < any.size(); ++i) any[i] |= may_see[i];
    }
    for (std::uint32_t i = 0; i < any.size(); ++i) {
        if (any[i]) tiles.open.push_back(i);
    }
    return tiles;
}

// What one thread traces with.
struct Pack {
    std::vector<Ray> rays;
    std::vector<RayHit> found;
    std::vector<SurfaceHit> nearest;
};

// The nearest hit of each of the pack's rays, which may see what the tile may.
void trace_pack(std::span<const FieldSurface> surfaces, const Tiles& tiles, std::uint32_t tile,
                double tolerance, Pack& pack)
{
    const std::size_t n = pack.rays.size();
    pack.found.resize(n);
    pack.nearest.assign(n, {});
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
        if (!tiles.may_see[s][tile]) continue;
        geometry::trace(surfaces[s].field, surfaces[s].cells, pack.rays, tolerance, pack.found);
        for (std::size_t i = 0; i < n; ++i) {
            const RayHit& hit = pack.found[i];
            if (!hit.there() || !(hit.t < pack.rays[i].end)) continue;
            pack.rays[i].end = hit.t;
            // Surfaces are seen from both sides.
            const bool away = hit.normal.dot(pack.rays[i].direction) > 0;
            pack.nearest[i] = {hit.t, Vec3f((away ? Vec3(-hit.normal) : hit.normal).cast<float>()),
                               static_cast<std::int32_t>(s)};
        }
    }
}

// Whether b, a pixel or two beside a, lies where a's plane continues.
bool continues(const RayGrid& grid, const SurfaceHit& a, const SurfaceHit& b, const Vec3& at_a,
               const Vec3& at_b)
{
    if (a.surface != b.surface) return false;
    if (a.surface < 0) return true;
    constexpr float eight_degrees = 0.990f;
    if (!(a.normal.dot(b.normal) > eight_degrees)) return false;
    const double expected = on_plane(grid, a, at_a.x(), at_a.y(), at_b.x(), at_b.y());
    const double pixel = grid.across.norm() * (grid.parallel ? 1 : a.t);
    return std::abs(expected - b.t) * grid.along.norm() < 4 * pixel;
}

bool grazing(const RayGrid& grid, const SurfaceHit& hit, double x, double y)
{
    const Vec3 d = grid.ray(x, y).direction;
    return hit.surface >= 0 && std::abs(hit.normal.cast<double>().dot(d)) < 0.1 * d.norm();
}

// Whether a pixel needs more rays: what it shows does not continue to its neighbours.
bool uneven(const RayGrid& grid, const RayPicture& picture, int column, int row)
{
    const SurfaceHit& here = picture.hits[picture.at(column, row)];
    const Vec3 at(picture.x + column + 0.5, picture.y + row + 0.5, 0);
    if (grazing(grid, here, at.x(), at.y())) return true;
    const int last_column = std::min(column + 1, picture.width - 1);
    const int last_row = std::min(row + 1, picture.height - 1);
    for (int y = std::max(0, row - 1); y <= last_row; ++y) {
        for (int x = std::max(0, column - 1); x <= last_column; ++x) {
            if (x == column && y == row) continue;
            const SurfaceHit& there = picture.hits[picture.at(x, y)];
            const Vec3 at_there(picture.x + x + 0.5, picture.y + y + 0.5, 0);
            if (!continues(grid, here, there, at, at_there)) return true;
        }
    }
    return false;
}

// The part of the picture that the open tiles cover.
RayPicture empty_picture(const Tiles& tiles, int width, int height)
{
    RayPicture picture;
    if (tiles.open.empty()) return picture;
    int right = 0, bottom = 0;
    picture.x = width;
    picture.y = height;
    for (const std::uint32_t tile : tiles.open) {
        picture.x = std::min(picture.x, tiles.x_of(tile));
        picture.y = std::min(picture.y, tiles.y_of(tile));
        right = std::max(right, std::min(width, tiles.x_of(tile) + tile_side));
        bottom = std::max(bottom, std::min(height, tiles.y_of(tile) + tile_side));
    }
    picture.width = right - picture.x;
    picture.height = bottom - picture.y;
    picture.hits.resize(picture.at(0, picture.height));
    picture.fine.assign(picture.hits.size(), 0);
    return picture;
}

// body(column, row) for the pixels of a tile, counted from the picture's first.
void for_pixels(const RayPicture& picture, const Tiles& tiles, std::uint32_t tile, const auto& body)
{
    const int left = tiles.x_of(tile) - picture.x, top = tiles.y_of(tile) - picture.y;
    const int bottom = std::min(picture.height, top + tile_side);
    const int right = std::min(picture.width, left + tile_side);
    for (int row = top; row < bottom; ++row) {
        for (int column = left; column < right; ++column) body(column, row);
    }
}

void trace_middles(std::span<const FieldSurface> surfaces, const RayGrid& grid, const Tiles& tiles,
                   double tolerance, RayPicture& picture)
{
    const auto some = [&](std::size_t begin, std::size_t end) {
        thread_local Pack pack;
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t tile = tiles.open[i];
            pack.rays.clear();
            for_pixels(picture, tiles, tile, [&](int column, int row) {
                pack.rays.push_back(grid.ray(picture.x + column + 0.5, picture.y + row + 0.5));
            });
            trace_pack(surfaces, tiles, tile, tolerance, pack);
            std::size_t next = 0;
            for_pixels(picture, tiles, tile, [&](int column, int row) {
                picture.hits[picture.at(column, row)] = pack.nearest[next++];
            });
        }
    };
    geometry::parallel_for(tiles.open.size(), 4, some);
}

// Numbers the uneven pixels, tile by tile. Returns where each open tile's numbers begin.
std::vector<std::uint32_t> number_uneven(const RayGrid& grid, const Tiles& tiles,
                                         std::size_t places, RayPicture& picture)
{
    std::vector<std::uint32_t> first(tiles.open.size() + 1, 0);
    geometry::parallel_for(tiles.open.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            for_pixels(picture, tiles, tiles.open[i], [&](int column, int row) {
                if (!uneven(grid, picture, column, row)) return;
                picture.fine[picture.at(column, row)] = 1;
                ++first[i + 1];
            });
        }
    });
    for (std::size_t i = 0; i < tiles.open.size(); ++i) first[i + 1] += first[i];
    for (std::size_t i = 0; i < tiles.open.size(); ++i) {
        std::uint32_t next = first[i];
        for_pixels(picture, tiles, tiles.open[i], [&](int column, int row) {
            std::uint32_t& fine = picture.fine[picture.at(column, row)];
            if (fine) fine = 1 + static_cast<std::uint32_t>(places) * next++;
        });
    }
    return first;
}

void trace_samples(std::span<const FieldSurface> surfaces, const RayGrid& grid, const Tiles& tiles,
                   std::span<const PixelPlace> places, double tolerance, RayPicture& picture)
{
    const std::vector<std::uint32_t> first = number_uneven(grid, tiles, places.size(), picture);
    picture.samples.resize(places.size() * first.back());
    const auto some = [&](std::size_t begin, std::size_t end) {
        thread_local Pack pack;
        for (std::size_t i = begin; i < end; ++i) {
            if (first[i] == first[i + 1]) continue;
            pack.rays.clear();
            for_pixels(picture, tiles, tiles.open[i], [&](int column, int row) {
                if (!picture.fine[picture.at(column, row)]) return;
                for (const auto& [x, y] : places) {
                    pack.rays.push_back(
                        grid.ray(picture.x + column + 0.5 + x, picture.y + row + 0.5 + y));
                }
            });
            trace_pack(surfaces, tiles, tiles.open[i], tolerance, pack);
            std::copy(pack.nearest.begin(), pack.nearest.end(),
                      picture.samples.begin() +
                          static_cast<std::ptrdiff_t>(places.size() * first[i]));
        }
    };
    geometry::parallel_for(tiles.open.size(), 4, some);
}

}  // namespace

Ray RayGrid::ray(double x, double y) const
{
    const Vec3 by = x * across + y * down;
    if (parallel) return {origin + by, along, begin};
    return {origin, along + by, begin};
}

double on_plane(const RayGrid& grid, const SurfaceHit& hit, double x0, double y0, double x,
                double y)
{
    const Vec3 n = hit.normal.cast<double>();
    const Ray from = grid.ray(x0, y0), to = grid.ray(x, y);
    const Vec3 p = from.origin + hit.t * from.direction;
    return n.dot(p - to.origin) / n.dot(to.direction);
}

RayPicture ray_picture(std::span<const FieldSurface> surfaces, const RayGrid& grid, int width,
                       int height, std::span<const PixelPlace> places, double tolerance,
                       bool casters)
{
    const Tiles tiles = tiles_of(surfaces, grid, width, height, casters);
    RayPicture picture = empty_picture(tiles, width, height);
    if (tiles.open.empty()) return picture;
    trace_middles(surfaces, grid, tiles, tolerance, picture);
    if (!places.empty()) trace_samples(surfaces, grid, tiles, places, tolerance, picture);
    return picture;
}

}  // namespace render
