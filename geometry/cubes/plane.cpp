#include "geometry/cubes/plane.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {

std::array<int, 2> plane_axes(int axis)
{
    return axis == 0 ? std::array{2, 1} : axis == 1 ? std::array{0, 2} : std::array{0, 1};
}

int flat_axis(const Cubes& cubes)
{
    for (int axis = 0; axis < 3 && cubes.count() > 0; ++axis) {
        const std::size_t bit = std::size_t{1} << axis;
        const bool flat =
            std::all_of(cubes.corners.begin(), cubes.corners.end(), [&](const auto& corners) {
                for (std::size_t a = 0; a < 8; ++a) {
                    if (corners[a] != corners[a | bit]) return false;
                }
                return true;
            });
        if (flat) return axis;
    }
    return -1;
}

void need_thickness(const Cubes& cubes, const char* who)
{
    if (flat_axis(cubes) < 0) return;
    if (cubes.is_sheet()) {
        throw std::invalid_argument(
            fmt::format("{} needs cubes with a thickness, found the sheet of a mesh: use method "
                        "shell, or Voxelize the mesh",
                        who));
    }
    throw std::invalid_argument(
        fmt::format("{} needs cubes with a thickness, found a plane: use method shell or "
                    "lattice, or Voxelize a solid model",
                    who));
}

namespace {

void limit(std::int64_t ni, std::int64_t nj)
{
    if (ni > 0 && nj > 0 && ni <= most_cells / nj) return;
    throw std::invalid_argument(
        fmt::format("expected a plane of 1 to {} cells, found {} by {}: change the size of the "
                    "cells",
                    most_cells, ni, nj));
}

Vec3i cell_at(const std::array<int, 2>& cell, int axis)
{
    const auto [u, v] = plane_axes(axis);
    Vec3i out = Vec3i::Zero();
    out[u] = cell[0];
    out[v] = cell[1];
    return out;
}

}  // namespace

Cells2 rectangle_cells(int ni, int nj)
{
    limit(ni, nj);
    Cells2 cells;
    for (int j = 0; j < nj; ++j) {
        for (int i = 0; i < ni; ++i) cells.push_back({i, j});
    }
    return cells;
}

Cells2 ellipse_cells(int ni, int nj)
{
    Cells2 cells = rectangle_cells(ni, nj);
    std::erase_if(cells, [&](const auto& cell) {
        const double x = (2 * cell[0] + 1.0) / ni - 1, y = (2 * cell[1] + 1.0) / nj - 1;
        return x * x + y * y > 1;
    });
    return cells;
}

Cells2 picture_cells(const PlanePicture& picture, int axis, int ni, double threshold)
{
    if (picture.width < 1 || picture.height < 1) {
        throw std::invalid_argument("expected a picture of at least one pixel");
    }
    const double pixels = double(picture.width) / ni;  // along the edge of a cell
    const auto nj = std::int64_t(std::max(1.0, std::round(picture.height / pixels)));
    limit(ni, nj);
    // Pixels [begin, end) of cell i of n, at least one.
    const auto span_of = [](std::int64_t i, std::int64_t n, int count) {
        const std::int64_t begin = i * count / n, end = (i + 1) * count / n;
        return std::pair(int(std::min<std::int64_t>(begin, count - 1)),
                         int(std::max(end, std::min<std::int64_t>(begin, count - 1) + 1)));
    };
    Cells2 cells;
    for (std::int64_t j = 0; j < nj; ++j) {
        const auto [top, bottom] = span_of(axis == 1 ? j : nj - 1 - j, nj, picture.height);
        for (int i = 0; i < ni; ++i) {
            const auto [left, right] = span_of(i, ni, picture.width);
            double sum = 0;
            for (int y = top; y < bottom; ++y) {
                for (int x = left; x < right; ++x) {
                    sum += double(picture.value[std::size_t(y) * std::size_t(picture.width) +
                                                std::size_t(x)]);
                }
            }
            if (sum >= threshold * (bottom - top) * (right - left)) cells.push_back({i, int(j)});
        }
    }
    return cells;
}

Cells2 footprint_cells(const TriMesh& mesh, const PlaneGrid& grid)
{
    const auto [u, v] = plane_axes(grid.axis);
    const auto place = [&, u = u, v = v](std::uint32_t i) {
        const Vec3 p = (mesh.positions[i].cast<double>() - grid.origin) / grid.size;
        return Eigen::Vector2d(p[u], p[v]);
    };
    Cells2 cells;
    for (const auto& t : mesh.triangles()) {
        if (std::max({t[0], t[1], t[2]}) >= mesh.positions.size()) continue;
        const Eigen::Vector2d a = place(t[0]), b = place(t[1]), c = place(t[2]);
        if (!a.allFinite() || !b.allFinite() || !c.allFinite()) continue;
        const Eigen::Vector2d lo = a.cwiseMin(b).cwiseMin(c), hi = a.cwiseMax(b).cwiseMax(c);
        // Its box is searched, so it is what must not be too large.
        const Eigen::Vector2d size = hi - lo;
        if (lo.cwiseAbs().cwiseMax(hi.cwiseAbs()).maxCoeff() > 1e8) {
            throw std::invalid_argument(
                "the mesh reaches farther than a hundred million cells: use "
                "larger cells, or check the unit of the mesh");
        }
        if (size.prod() > 4.0 * most_cells) limit(std::int64_t(size.x()), std::int64_t(size.y()));
        // Middles i + 1/2 within the bounds.
        for (int j = int(std::ceil(lo.y() - 0.5)); j + 0.5 <= hi.y(); ++j) {
            for (int i = int(std::ceil(lo.x() - 0.5)); i + 0.5 <= hi.x(); ++i) {
                const Eigen::Vector2d p(i + 0.5, j + 0.5);
                const auto side = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
                    return (to.x() - from.x()) * (p.y() - from.y()) -
                           (to.y() - from.y()) * (p.x() - from.x());
                };
                const double ab = side(a, b), bc = side(b, c), ca = side(c, a);
                const bool in = (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
                if (in) cells.push_back({i, j});
            }
        }
        if (std::int64_t(cells.size()) > 4 * most_cells) limit(std::int64_t(cells.size()), 1);
    }
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    return cells;
}

Cubes plane_cubes(const Cells2& cells, const PlaneGrid& grid, double thickness,
                  const Matter& matter)
{
    if (cells.empty()) {
        throw std::invalid_argument("the plane has no cells: its outline is empty, or narrower "
                                    "than a cell");
    }
    if (!(grid.size > 0) || !std::isfinite(grid.size) || !(thickness > 0) ||
        !std::isfinite(thickness)) {
        throw std::invalid_argument(
            fmt::format("expected a size of the cells and a thickness above 0 m, found {} and {}",
                        grid.size, thickness));
    }
    std::vector<Vec3i> places;
    for (const auto& cell : cells) places.push_back(cell_at(cell, grid.axis));
    Cubes cubes = solid_cubes(std::move(places), grid.size, matter, grid.origin);
    stop_if_asked();
    std::fill(cubes.fill.begin(), cubes.fill.end(), thickness / grid.size);
    for (double& m : cubes.mass) m *= thickness / grid.size;

    // The upper face becomes the lower one, and its corners go.
    const std::size_t bit = std::size_t{1} << grid.axis;
    std::vector<std::uint32_t> number(cubes.corner_count(), 0);
    for (auto& corners : cubes.corners) {
        for (std::size_t a = 0; a < 8; ++a) {
            corners[a] = corners[a & ~bit];
            number[corners[a]] = 1;
        }
    }
    stop_if_asked();
    std::vector<Vec3i> kept;
    for (std::size_t k = 0; k < number.size(); ++k) {
        if (number[k] == 0) continue;
        number[k] = std::uint32_t(kept.size());
        kept.push_back(cubes.corner[k]);
    }
    cubes.corner = std::move(kept);
    for (auto& corners : cubes.corners) {
        for (auto& k : corners) k = number[k];
    }
    return cubes;
}

namespace {

// The corners of a cell in the order in which it faces along the flat axis.
std::array<std::uint32_t, 4> ring(const std::array<std::uint32_t, 8>& corners, int axis)
{
    const auto [u, v] = plane_axes(axis);
    const std::size_t i = std::size_t{1} << u, j = std::size_t{1} << v;
    if (axis == 2) return {corners[0], corners[i], corners[i | j], corners[j]};
    return {corners[0], corners[j], corners[i | j], corners[i]};
}

}  // namespace

TriMesh plane_mesh(const Cubes& plane)
{
    if (plane.is_sheet()) return sheet_mesh(plane);
    const int axis = flat_axis(plane);
    if (axis < 0) throw std::invalid_argument("expected a plane, found cubes with a thickness");
    const auto [u, v] = plane_axes(axis);
    TriMesh mesh;
    auto topology = std::make_shared<MeshTopology>();
    StopCheck check;
    for (const auto& corners : plane.corners) {
        check();
        const auto [a, b, c, d] = ring(corners, axis);
        topology->triangles.push_back({a, b, c});
        topology->triangles.push_back({a, c, d});
    }
    Vec3i lo = plane.corner[0], hi = lo;
    for (const Vec3i& p : plane.corner) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
    for (std::size_t k = 0; k < plane.corner_count(); ++k) {
        check();
        mesh.positions.push_back(plane.corner_position(k).cast<float>());
        mesh.normals.push_back(Vec3f::Unit(axis));
        const Vec3i from_low = plane.corner[k] - lo, size = hi - lo;
        topology->uvs.emplace_back(float(from_low[u]) / float(size[u]),
                                   float(from_low[v]) / float(size[v]));
    }
    stop_if_asked();
    topology->normal_triangles = topology->triangles;
    topology->uv_triangles = topology->triangles;
    mesh.topology = std::move(topology);
    return mesh;
}

std::vector<Vec3> plane_normals(const Cubes& plane, std::span<const Vec3> x,
                                std::span<const std::uint8_t> torn)
{
    if (plane.is_sheet()) return sheet_normals(plane, x);
    const int axis = flat_axis(plane);
    std::vector<Vec3> normal(plane.corner_count(), Vec3::Zero());
    for (std::size_t cell = 0; cell < plane.count(); ++cell) {
        if (!torn.empty() && torn[cell]) continue;
        const auto [a, b, c, d] = ring(plane.corners[cell], axis);
        const Vec3 n = (x[c] - x[a]).cross(x[d] - x[b]);  // twice the area
        for (const auto k : {a, b, c, d}) normal[k] += n;
    }
    for (Vec3& n : normal) {
        const double length = n.norm();
        n = length > 0 && std::isfinite(length) ? Vec3(n / length) : Vec3(Vec3::Unit(axis));
    }
    return normal;
}

}  // namespace geometry
