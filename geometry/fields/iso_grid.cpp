#include "geometry/fields/iso_grid.hpp"

#include "geometry/base/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {

IsoGrid iso_grid(const IsoField& field, double cell, std::size_t max_triangles)
{
    if (!(cell > 0) || !std::isfinite(cell)) {
        throw std::invalid_argument(fmt::format("cell must be above 0 m, got {}.", cell));
    }
    if (field.domain.empty()) return {field, cell, Vec3i::Zero(), Vec3i::Zero(), max_triangles};
    const Vec3 lo = (field.domain.lo / cell).array().floor() - 1;
    const Vec3 hi = (field.domain.hi / cell).array().ceil() + 1;
    constexpr double most = 1 << 20;
    if (!((hi - lo).maxCoeff() <= most) || !(lo.cwiseAbs().maxCoeff() < 1e9)) {
        throw std::invalid_argument(fmt::format("the surface of {} x {} x {} m with cell = {} m "
                                                "needs more than {} cells along an axis, "
                                                "or lies too far from the origin. Use larger cells",
                                                field.domain.size().x(), field.domain.size().y(),
                                                field.domain.size().z(), cell, most));
    }
    return {field, cell, lo.cast<int>(), hi.cast<int>(), max_triangles};
}

bool block_before(const Vec3i& a, const Vec3i& b)
{
    return std::array{a.z(), a.y(), a.x()} < std::array{b.z(), b.y(), b.x()};
}

std::vector<Vec3i> crossed_blocks(const IsoGrid& grid)
{
    if (grid.field.domain.empty()) return {};
    const auto floor_div = [](int a) { return (a >= 0 ? a : a - block_cells + 1) / block_cells; };
    const Vec3i lo = grid.lo.unaryExpr(floor_div);
    const Vec3i hi = (grid.hi.array() - 1).matrix().unaryExpr(floor_div) + Vec3i::Ones();
    int width = 1;
    while (width < (hi - lo).maxCoeff()) width *= 2;
    std::vector<Vec3i> open{lo};
    for (;; width /= 2) {
        std::vector<char> keep(open.size());
        parallel_for(open.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Box box;
                box.add(grid.point(block_cells * open[i]));
                box.add(grid.point(block_cells * (open[i].array() + width).matrix().cwiseMin(hi)));
                const Interval range = grid.field.bounds(box);
                // A hair wider than the bounds: their last digit may be off.
                const double hair = 1e-12 * (std::abs(range.lo) + std::abs(range.hi));
                keep[i] = range.lo <= hair && range.hi >= -hair;
            }
        });
        std::size_t kept = 0;
        for (std::size_t i = 0; i < open.size(); ++i) {
            if (keep[i]) open[kept++] = open[i];
        }
        open.resize(kept);
        // A block that the surface does pass has a hundred triangles and more.
        constexpr std::size_t quick = 100'000;
        if (kept > std::max(quick, grid.max_triangles / 25)) throw TooManyTriangles();
        if (width == 1) break;
        std::vector<Vec3i> halves;
        for (const Vec3i& at : open) {
            for (int c = 0; c < 8; ++c) {
                const Vec3i child = at + width / 2 * Vec3i(c & 1, c >> 1 & 1, c >> 2);
                if ((child.array() < hi.array()).all()) halves.push_back(child);
            }
        }
        open = std::move(halves);
    }
    std::sort(open.begin(), open.end(), block_before);
    return open;
}

void onto_surface(const IsoField& field, std::span<Vec3> vertices, std::span<const Vec3> low,
                  double width, std::span<Vec3f> positions, std::span<Vec3f> normals)
{
    FieldBlock points;
    BlockValues values;
    for (std::size_t begin = 0; begin < vertices.size(); begin += FieldBlock::capacity) {
        const std::size_t end = std::min(vertices.size(), begin + FieldBlock::capacity);
        constexpr int steps = 2;
        for (int step = 0; step <= steps; ++step) {
            points.count = 0;
            for (std::size_t i = begin; i < end; ++i) points.add(vertices[i]);
            points.pad();
            field.ask(points, values);
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3 gradient = values.gradient(i - begin);
                const double slope_sq = gradient.squaredNorm();
                if (!(slope_sq > 0)) continue;
                const Vec3 to = vertices[i] - values.f[i - begin] / slope_sq * gradient;
                vertices[i] = to.cwiseMax(low[i]).cwiseMin((low[i].array() + width).matrix());
            }
        }
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 gradient = values.gradient(i - begin);
            const double slope = gradient.norm();
            positions[i] = vertices[i].cast<float>();
            normals[i] =
                slope > 0 ? Vec3f((-gradient / slope).cast<float>()) : Vec3f(Vec3f::UnitY());
        }
    }
}

}  // namespace geometry
