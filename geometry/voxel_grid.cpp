#include "geometry/voxel_grid.hpp"

#include "geometry/cell_set.hpp"

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
        throw std::invalid_argument("there is nothing to voxelize: no triangle or point with "
                                    "finite coordinates came in");
    }
    const Vec3 extent = box.size();
    if (!(size > 0) || !std::isfinite(size)) {
        throw std::invalid_argument("the size of a cube should be a positive length, but is " +
                                    short_number(size) + " m");
    }
    VoxelGrid grid;
    grid.size = size;
    for (int k = 0; k < 3; ++k) {
        const double cubes = extent[k] / size;
        if (!(cubes < longest)) {
            throw std::invalid_argument("a model " + short_number(extent.maxCoeff()) +
                                        " m long in cubes of " + short_number(size) +
                                        " m is more than " + std::to_string(longest) +
                                        " cubes long: use cubes of at least " +
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
    if (!(extent > 0)) {
        throw std::invalid_argument("a model without extent has no resolution: all its points "
                                    "lie on one spot; give a size instead");
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
    for (const Triangle& t : out.triangles) {
        for (const std::uint32_t v : t) {
            if (!(out.positions[v].cwiseAbs().maxCoeff() < longest)) {
                throw std::invalid_argument(
                    "the model reaches " +
                    short_number(grid.size * out.positions[v].cwiseAbs().maxCoeff()) +
                    " m from the grid's origin, more than " + std::to_string(longest) +
                    " cubes of " + short_number(grid.size) +
                    " m: use larger cubes, or an origin near the model");
            }
        }
    }
    return out;
}

}  // namespace geometry
