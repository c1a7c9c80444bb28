#pragma once

// Which of several surfaces without triangles the ray of each pixel meets first.
//
//   cells of a surface --project--> tiles of 16 x 16 pixels that it may be seen in
//   each such tile: a ray through the middle of each pixel, surface by surface
//   pixels whose neighbours do not continue them (silhouettes, creases, borders): more rays
//
// The same bytes for any number of threads: a tile's rays go by themselves.

#include "geometry/fields/iso_rays.hpp"
#include "render/scene.hpp"

#include <array>
#include <span>
#include <vector>

namespace render {

// A ray for each place of a picture, x and y in pixels from the upper left corner:
//   origin + t * (along + x * across + y * down), or, where `parallel`,
//   origin + x * across + y * down + t * along.
struct RayGrid {
    Vec3 origin = Vec3::Zero(), along = Vec3::UnitZ(), across = Vec3::UnitX(), down = Vec3::UnitY();
    bool parallel = false;
    double begin = 0;  // t

    geometry::Ray ray(double x, double y) const;
};

// Where in its pixel a sample lies, from the middle.
using PixelPlace = std::array<double, 2>;

struct SurfaceHit {
    double t = 0;  // of the ray
    Vec3f normal = Vec3f::Zero();
    std::int32_t surface = -1;  // -1: nothing
};

struct RayPicture {
    int x = 0, y = 0, width = 0, height = 0;  // the part of the picture that it tells of
    std::vector<SurfaceHit> hits;             // width * height, through the pixels' middles
    // 0: the pixel's plane continues to its borders; else 1 + the number of its first sample.
    std::vector<std::uint32_t> fine;
    std::vector<SurfaceHit> samples;  // one a place, pixel by pixel

    std::size_t at(int column, int row) const
    {
        return static_cast<std::size_t>(column) +
               static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    }
};

// Of a picture of `width` x `height`. `places`: of the samples of uneven pixels; none: there are no
// such. `tolerance`: m, along the rays. `casters`: only surfaces that cast shadows.
RayPicture ray_picture(std::span<const FieldSurface> surfaces, const RayGrid& grid, int width,
                       int height, std::span<const PixelPlace> places, double tolerance,
                       bool casters = false);

// t at which the ray through (x, y) meets the plane of a hit of the ray through (x0, y0).
double on_plane(const RayGrid& grid, const SurfaceHit& hit, double x0, double y0, double x,
                double y);

}  // namespace render
