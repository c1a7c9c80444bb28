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

static void require_near(const LatticeMesh& mesh, const VoxelGrid& grid)
{
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            if (!(mesh.positions[v].cwiseAbs().maxCoeff() < longest)) {
                throw std::invalid_argument(
                    "the model reaches " +
                    short_number(grid.size * mesh.positions[v].cwiseAbs().maxCoeff()) +
                    " m from the origin of the grid, more than the limit of " +
                    std::to_string(longest) + " cubes of " + short_number(grid.size) +
                    " m: use larger cubes, or move the origin nearer to the model");
            }
        }
    }
}

static std::vector<Vec3> in_lattice(const TriMesh& mesh, const VoxelGrid& grid)
{
    std::vector<Vec3> out(mesh.positions.size());
    for (std::size_t v = 0; v < out.size(); ++v) out[v] = grid.lattice(mesh.positions[v]);
    stop_if_asked();
    return out;
}

LatticeMesh to_lattice(const TriMesh& mesh, const VoxelGrid& grid)
{
    LatticeMesh out;
    out.positions = in_lattice(mesh, grid);
    const auto good = [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
            return v < mesh.positions.size() && mesh.positions[v].allFinite();
        });
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
    require_near(out, grid);
    return out;
}

LatticeMesh to_lattice(const TriMesh& mesh, const SolidFaces& faces, const VoxelGrid& grid)
{
    LatticeMesh out;
    out.positions = in_lattice(mesh, grid);
    out.triangles = faces.triangles;
    out.source = faces.source;
    require_near(out, grid);
    out.closed = is_closed(out);
    return out;
}

bool is_closed(const LatticeMesh& mesh)
{
    return mesh.closed ? *mesh.closed : is_closed(mesh.triangles, mesh.positions.size());
}

}  // namespace geometry
