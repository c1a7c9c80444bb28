#include "geometry/cells/voxel_grid.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/cells/cell_set.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace geometry {
namespace {

constexpr double snap = 1e-6;                 // of a cube
constexpr double float_spacing = 0x1p-23;     // relative
constexpr int longest = CellSet::extent - 1;  // cubes along an axis

}  // namespace

std::string short_number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

Vec3 VoxelGrid::lattice(const Vec3f& p) const
{
    Vec3 q;
    for (int k = 0; k < 3; ++k) {
        const double x = double(p[k]);
        double at = (x - origin[k]) / size;
        const double nearest = std::nearbyint(at);
        const double close = std::min(0.01, std::max(snap, float_spacing * std::abs(x) / size));
        if (std::abs(at - nearest) <= close) at = nearest;
        if (cells[k] > 0) {
            at = std::clamp(at, 0.0, std::nextafter(static_cast<double>(cells[k]), 0.0));
        }
        q[k] = at;
    }
    return q;
}

Box finite_bounds(std::span<const Vec3f> points)
{
    Box box;
    for (const Vec3f& p : points) {
        if (p.allFinite()) box.add(p.cast<double>());
    }
    return box;
}

Box triangle_bounds(const TriMesh& mesh)
{
    Box box;
    for (const Triangle& t : mesh.triangles()) {
        if (std::max({t[0], t[1], t[2]}) >= mesh.positions.size()) continue;
        const Vec3f &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        if (!(a + b + c).allFinite()) continue;
        for (const Vec3f& p : {a, b, c}) box.add(p.cast<double>());
    }
    return box;
}

VoxelGrid fit_grid(const Box& box, double size)
{
    if (box.empty()) {
        throw std::invalid_argument("nothing to voxelize: expected at least one triangle or "
                                    "point with finite coordinates");
    }
    const Vec3 extent = box.size();
    if (!(size > 0) || !std::isfinite(size)) {
        throw std::invalid_argument("size of a cube: expected a positive length, found " +
                                    short_number(size) + " m");
    }
    VoxelGrid grid;
    grid.size = size;
    for (int k = 0; k < 3; ++k) {
        const double cubes = extent[k] / size;
        if (!(cubes < longest)) {
            throw std::invalid_argument("a model " + short_number(extent.maxCoeff()) +
                                        " m long in cubes of " + short_number(size) +
                                        " m exceeds the limit of " + std::to_string(longest) +
                                        " cubes along an axis: use cubes of at least " +
                                        short_number(1.01 * extent.maxCoeff() / longest) + " m");
        }
        // A model that is a whole number of cubes long within rounding needs no further cube.
        const double close =
            std::max(snap, float_spacing * box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs())[k] / size);
        grid.cells[k] = std::max(1, static_cast<int>(std::ceil(cubes - std::min(close, 0.01))));
        grid.origin[k] = box.centre()[k] - 0.5 * size * grid.cells[k];
    }
    return grid;
}

double size_for(const Box& box, int resolution)
{
    const double extent = box.size().maxCoeff();
    const double farthest = box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs()).maxCoeff();
    if (!(extent > 0) && float_spacing * farthest > 1e-3) {
        throw std::invalid_argument(
            "all points of the model are in one place, " + short_number(farthest) +
            " m from the origin, where coordinates are rounded to steps "
            "of " +
            short_number(float_spacing * farthest) + " m: move it to the origin before this step");
    }
    if (!(extent > 0)) {
        throw std::invalid_argument("a resolution needs a model with an extent, but all points of "
                                    "this one are in one place: set a size instead");
    }
    return extent / resolution;
}

LatticeMesh to_lattice(const TriMesh& mesh, const VoxelGrid& grid)
{
    LatticeMesh out;
    out.positions.resize(mesh.positions.size());
    std::vector<std::uint8_t> usable(mesh.positions.size(), 1);
    for (std::size_t v = 0; v < out.positions.size(); ++v) {
        usable[v] = mesh.positions[v].allFinite();
        out.positions[v] = grid.lattice(mesh.positions[v]);
    }
    stop_if_asked();
    const auto good = [&](const Triangle& t) {
        return std::max({t[0], t[1], t[2]}) < usable.size() && usable[t[0]] && usable[t[1]] &&
               usable[t[2]];
    };
    const std::vector<Triangle>& all = mesh.triangles();
    if (std::all_of(all.begin(), all.end(), good)) {
        out.triangles = all;
    } else {
        for (std::uint32_t t = 0; t < all.size(); ++t) {
            if (!good(all[t])) continue;
            out.triangles.push_back(all[t]);
            out.source.push_back(t);
        }
    }
    stop_if_asked();
    for (const Triangle& t : out.triangles) {
        for (const std::uint32_t v : t) {
            if (!(out.positions[v].cwiseAbs().maxCoeff() < longest)) {
                throw std::invalid_argument(
                    "the model reaches " +
                    short_number(grid.size * out.positions[v].cwiseAbs().maxCoeff()) +
                    " m from the origin of the grid, more than the limit of " +
                    std::to_string(longest) + " cubes of " + short_number(grid.size) +
                    " m: use larger cubes, or move the origin nearer to the model");
            }
        }
    }
    return out;
}

bool is_closed(const LatticeMesh& mesh)
{
    return mesh.closed ? *mesh.closed : is_closed(mesh.triangles, mesh.positions.size());
}

}  // namespace geometry
