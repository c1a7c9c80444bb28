#include "geometry/cubes/sample_volume.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/random.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cells/cell_lines.hpp"
#include "geometry/cells/inside_shares.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/cubes/solid_matter.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

VoxelGrid grid_over(const TriMesh& mesh, double size)
{
    return fit_grid(triangle_bounds(mesh), size);
}

// One point in each cell of the grid, of those that are inside. Where the surface passes through
// the cell, points stand where they were found inside; elsewhere they may lie a little off.
// Throws TooManyCells where more than `limit` are inside or hold the surface.
std::vector<Vec3f> jittered(const TriMesh& mesh, const SolidFaces& solid, Inside rule, double size,
                            std::size_t limit, const Random& random)
{
    const VoxelGrid grid = grid_over(mesh, size);
    const LatticeMesh lattice = to_lattice(mesh, solid, grid);
    const std::vector<Vec3i> cells = solid_cells(lattice, rule, limit).sorted();
    std::vector<Vec3i> border = surface_cells(lattice, CellShape::half_open, limit).sorted();
    const CellIndex index(cells);
    std::erase_if(border, [&](const Vec3i& c) { return !index.find(c); });
    const std::vector<std::uint64_t> inside = cell_lines(lattice, rule, border).inside;
    std::vector<std::uint64_t> allowed(cells.size(), ~std::uint64_t{0});
    std::vector<std::uint8_t> whole(cells.size(), 1);
    for (std::size_t i = 0; i < border.size(); ++i) {
        const std::uint32_t c = index.find(border[i]).begin;
        allowed[c] = inside[i];
        whole[c] = 0;
    }
    std::vector<Vec3f> points;
    StopCheck check;
    for (std::size_t c = 0; c < cells.size(); ++c) {
        check();
        const std::uint64_t bits = random.bits(c);
        const unsigned at = bits & 63;  // one of 4 x 4 x 4 parts of the cell
        if ((allowed[c] >> at & 1) == 0) continue;
        Vec3 p(at & 3, at >> 2 & 3, at >> 4);
        for (int k = 0; k < 3; ++k) {
            p[k] += whole[c] ? static_cast<double>(bits >> (6 + 19 * k) & 0x7ffff) * 0x1p-19 : 0.5;
        }
        points.push_back((grid.origin + size * (cells[c].cast<double>() + 0.25 * p)).cast<float>());
    }
    return points;
}

// The same, with an error for a volume that is too little for its surface.
std::vector<Vec3f> jittered_or_refused(const TriMesh& mesh, const SolidFaces& solid, Inside rule,
                                       double size, std::size_t count, double volume,
                                       const Random& random)
{
    try {
        return jittered(mesh, solid, rule, size, 2'000'000 + 10 * count, random);
    } catch (const TooManyCells&) {
        throw std::invalid_argument(fmt::format(
            "the faces of {:.3g} m^2 enclose only {:.3g} m^3, which is too little for {} samples. "
            "Their orientations may disagree: set inside = parity, or set where = surface to "
            "sample the faces",
            sampled_area(mesh), volume, count));
    }
}

// Leaves out points at random until `count` are left; the rest keep their order.
void thin_out(std::vector<Vec3f>& points, std::size_t count, const Random& random)
{
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(points.size());
    for (std::uint32_t i = 0; i < keys.size(); ++i) keys[i] = {random.bits(i), i};
    std::nth_element(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(count), keys.end());
    std::vector<std::uint32_t> stay(count);
    for (std::size_t i = 0; i < count; ++i) stay[i] = keys[i].second;
    std::sort(stay.begin(), stay.end());
    for (std::size_t i = 0; i < count; ++i) points[i] = points[stay[i]];
    points.resize(count);
}

}  // namespace

static double volume_inside(const TriMesh& mesh, const SolidFaces& solid, Inside rule,
                            int resolution)
{
    const Box box = triangle_bounds(mesh);
    if (box.empty() || !(box.size().maxCoeff() > 0)) return 0;
    const VoxelGrid grid = grid_over(mesh, size_for(box, resolution));
    const LatticeMesh lattice = to_lattice(mesh, solid, grid);
    const CellSet cells = solid_cells(lattice, rule);
    const InsideShares border = inside_shares(lattice, rule);
    double sum = static_cast<double>(cells.count());
    for (std::size_t i = 0; i < border.cells.size(); ++i) {
        if (cells.contains(border.cells[i])) sum += border.share[i] - 1;
    }
    return sum * grid.size * grid.size * grid.size;
}

double volume_inside(const TriMesh& mesh, Inside rule, int resolution)
{
    return volume_inside(mesh, solid_faces(mesh), rule, resolution);
}

Samples sample_volume(const TriMesh& mesh, const FaceMatter& matter, Inside rule, std::size_t count,
                      std::uint64_t seed, const SampleMass& mass)
{
    if (mass.by == SampleMass::By::surface_density) {
        throw std::invalid_argument("samples in a volume have no surface density: set the mass by "
                                    "total or by density");
    }
    const SolidFaces solid = solid_faces(mesh, matter.face);
    const double volume = volume_inside(mesh, solid, rule, 64);
    if (!(volume > 0)) {
        throw std::invalid_argument("the mesh encloses no volume to sample. It may be open, or its "
                                    "faces may disagree on what is outside: sample its surface, "
                                    "or try the other rule for what is inside");
    }
    Samples out;
    double size = std::cbrt(volume / static_cast<double>(count));
    for (std::uint64_t round = 0; out.positions.size() < count; ++round) {
        if (round == 50) {
            throw std::runtime_error("the inside of the mesh is too thin for " +
                                     std::to_string(count) + " samples: only " +
                                     std::to_string(out.positions.size()) + " were found");
        }
        out.positions =
            jittered_or_refused(mesh, solid, rule, size, count, volume, Random(seed + round));
        const double share = static_cast<double>(out.positions.size()) / static_cast<double>(count);
        size *= std::clamp(std::cbrt(share) * 0.995, 0.5, 0.995);
    }
    thin_out(out.positions, count, Random(~seed));

    out.matters = matter.matters;
    out.matter.assign(count, 0);
    if (matter.matters.size() > 1) {
        std::vector<Vec3> points(count);
        for (std::size_t i = 0; i < count; ++i) points[i] = out.positions[i].cast<double>();
        const LatticeMesh lattice = to_lattice(mesh, solid, grid_over(mesh, size));
        out.matter = matter_at({mesh, lattice, matter, rule, 0}, points);
    }
    out.mass.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        out.mass[i] = static_cast<float>(volume / static_cast<double>(count) *
                                         out.matters[out.matter[i]].density);
    }
    if (mass.by == SampleMass::By::total) scale_mass(out, mass.total);
    return out;
}

}  // namespace geometry
