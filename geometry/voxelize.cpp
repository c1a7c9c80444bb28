#include "geometry/voxelize.hpp"

#include "geometry/border_shares.hpp"
#include "geometry/clip_to_cells.hpp"
#include "geometry/parallel.hpp"
#include "geometry/surface_cells.hpp"
#include "geometry/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace geometry {
namespace {

VoxelGrid coarser(const VoxelGrid& grid, double factor)
{
    VoxelGrid out = grid;
    out.size *= factor;
    for (int k = 0; k < 3; ++k) {
        out.cells[k] = static_cast<int>(std::ceil(grid.cells[k] / factor));
    }
    return out;
}

// The cells that find(grid) gives; where they are too many, an error that names a size that fits,
// found by trying.
template <class Find>
CellSet within_limit(const VoxelGrid& grid, const VoxelOptions& options, const Find& find)
{
    try {
        return find(grid);
    } catch (const TooManyCells&) {
    }
    const int most = std::max(1, grid.cells.maxCoeff());
    double factor = 1;
    for (bool fits = false; !fits && factor < 2.0 * most + 1e7;) {
        factor *= 1.2;
        try {
            find(coarser(grid, factor));
            fits = true;
        } catch (const TooManyCells&) {
        }
    }
    throw std::invalid_argument(
        "cubes of " + short_number(grid.size) +
        " m are more than max_cubes = " + std::to_string(options.max_cubes) + "; cubes of " +
        short_number(1.01 * factor * grid.size) + " m would fit, or raise max_cubes");
}

Cubes with_corners(const VoxelGrid& grid, const CellSet& cells)
{
    Cubes cubes;
    cubes.size = grid.size;
    cubes.origin = grid.origin;
    cubes.cell = cells.sorted();
    number_corners(cubes);
    return cubes;
}

// The area of the faces in each cube, in m^2, face by face.
struct Patch {
    std::uint32_t cube, triangle;  // triangle of the lattice mesh
    double area;
};

std::vector<Patch> patches(const LatticeMesh& mesh, const CellIndex& index, double size)
{
    constexpr std::size_t grain = 4096;
    const std::size_t pieces = (mesh.triangles.size() + grain - 1) / grain;
    std::vector<std::vector<Patch>> parts(pieces);
    parallel_for(pieces, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t last = std::min((i + 1) * grain, mesh.triangles.size());
            parts[i].reserve(4 * grain);
            for (std::size_t t = i * grain; t < last; ++t) {
                const auto& [a, b, c] = mesh.triangles[t];
                clip_to_cells(mesh.positions[a], mesh.positions[b], mesh.positions[c],
                              [&](const Vec3i& cell, double area) {
                                  if (!(area > 0)) return;
                                  const auto found = index.find(cell);
                                  if (!found) return;
                                  parts[i].push_back({found.begin, static_cast<std::uint32_t>(t),
                                                      area * size * size});
                              });
            }
        }
    });
    std::vector<Patch> all;
    std::size_t count = 0;
    for (const auto& part : parts) count += part.size();
    all.reserve(count);
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

void require(const LatticeMesh& mesh)
{
    if (mesh.triangles.empty()) {
        throw std::invalid_argument("there is nothing to voxelize: the mesh has no triangle with "
                                    "finite corners (for a point cloud, voxelize samples)");
    }
}

double cube_volume(const VoxelGrid& grid)
{
    return grid.size * grid.size * grid.size;
}

// Full cubes share their volume between matters by the faces' area in them.
void scale_to(std::vector<Deposit>& deposits, std::span<const double> volume, std::size_t cubes)
{
    std::vector<double> sum(cubes, 0.0);
    for (const Deposit& d : deposits) sum[d.cube] += d.volume;
    for (Deposit& d : deposits) d.volume *= volume[d.cube] / sum[d.cube];
}

}  // namespace

Cubes voxelize_samples(const Samples& samples, const VoxelGrid& grid, const VoxelOptions& options)
{
    const std::size_t n = samples.positions.size();
    std::vector<Vec3> at(n);
    std::vector<std::uint8_t> usable(n);
    const auto place = [&](const VoxelGrid& g) {
        parallel_for(n, 16384, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                at[i] = g.lattice(samples.positions[i]);
                usable[i] = samples.positions[i].allFinite() &&
                            at[i].cwiseAbs().maxCoeff() < CellSet::extent - 1;
            }
        });
        CellSet cells(options.max_cubes);
        for (std::size_t i = 0; i < n; ++i) {
            if (usable[i]) cells.insert(cell_of(at[i]));
        }
        return cells;
    };
    CellSet cells = within_limit(grid, options, place);
    if (cells.count() == 0) {
        throw std::invalid_argument("there is nothing to voxelize: no sample has finite "
                                    "coordinates within reach of the grid");
    }
    Cubes cubes = with_corners(grid, cells);
    const CellIndex index(std::move(cells), cubes.cell);
    const bool full = !(samples.bulk > 0);
    constexpr double least_volume = 1e-300;  // of a sample without mass, where others count more
    std::vector<Deposit> deposits;
    deposits.reserve(n);
    for (std::size_t i = 0; i < n; ++i) {
        if (!usable[i]) continue;
        const std::uint16_t m = samples.matter.empty() ? std::uint16_t{0} : samples.matter[i];
        const double volume = double(samples.mass[i]) / samples.matters[m].density;
        deposits.push_back({index.find(cell_of(at[i])).begin, m,
                            full ? std::max(volume, least_volume) : samples.bulk * volume});
    }
    if (full) {
        scale_to(deposits, std::vector<double>(cubes.count(), cube_volume(grid)), cubes.count());
    }
    VoxelOptions asked = options;
    if (asked.total_mass == 0) asked.total_mass = samples.total_mass;
    fill_cubes(cubes, samples.matters, deposits, asked);
    return cubes;
}

Cubes voxelize_surface(const TriMesh& mesh, const FaceMatter& matter, double thickness,
                       const VoxelGrid& grid, const VoxelOptions& options)
{
    const LatticeMesh lattice = to_lattice(mesh, grid);
    require(lattice);
    CellSet cells = within_limit(grid, options, [&](const VoxelGrid& g) {
        return surface_cells(g.size == grid.size ? lattice : to_lattice(mesh, g), Touch::half_open,
                             options.max_cubes);
    });
    Cubes cubes = with_corners(grid, cells);
    const CellIndex index(std::move(cells), cubes.cell);
    std::vector<Deposit> deposits;
    const bool full = !(thickness > 0);
    if (full && matter.matters.size() == 1) {
        for (std::uint32_t c = 0; c < cubes.count(); ++c) {
            deposits.push_back({c, 0, cube_volume(grid)});
        }
    } else {
        for (const Patch& p : patches(lattice, index, grid.size)) {
            deposits.push_back({p.cube, matter.of(lattice.source_of(p.triangle)),
                                p.area * (full ? grid.size : thickness)});
        }
        if (full) {
            scale_to(deposits, std::vector<double>(cubes.count(), cube_volume(grid)),
                     cubes.count());
        }
    }
    fill_cubes(cubes, matter.matters, deposits, options);
    return cubes;
}

Cubes voxelize_solid(const TriMesh& mesh, const FaceMatter& matter, Inside rule, double thickness,
                     const VoxelGrid& grid, const VoxelOptions& options)
{
    const LatticeMesh lattice = to_lattice(mesh, grid);
    require(lattice);
    CellSet cells = within_limit(grid, options, [&](const VoxelGrid& g) {
        return solid_cells(g.size == grid.size ? lattice : to_lattice(mesh, g), rule,
                           options.max_cubes);
    });
    Cubes cubes = with_corners(grid, cells);

    // Whole cubes, but for those that the surface passes through.
    std::vector<double> volume(cubes.count(), cube_volume(grid));
    const CellIndex index(std::move(cells), cubes.cell);
    const BorderShares border = border_shares(lattice, rule);
    for (std::size_t i = 0; i < border.cells.size(); ++i) {
        if (const auto found = index.find(border.cells[i])) {
            volume[found.begin] = border.share[i] * cube_volume(grid);
        }
    }
    const bool one = matter.matters.size() == 1;
    std::vector<Patch> faces;
    if (!one || thickness > 0) faces = patches(lattice, index, grid.size);
    if (thickness > 0) {
        std::vector<double> sheet(cubes.count(), 0.0);
        for (const Patch& p : faces) sheet[p.cube] += p.area * thickness;
        for (std::size_t c = 0; c < sheet.size(); ++c) {
            volume[c] = std::max(volume[c], std::min(sheet[c], cube_volume(grid)));
        }
    }
    std::vector<Deposit> deposits;
    deposits.reserve(cubes.count() + faces.size());
    std::vector<std::uint8_t> has_face(cubes.count(), 0);
    if (!one) {
        for (const Patch& p : faces) {
            deposits.push_back({p.cube, matter.of(lattice.source_of(p.triangle)), p.area});
            has_face[p.cube] = 1;
        }
        scale_to(deposits, volume, cubes.count());
    }
    std::vector<Vec3> centres;
    std::vector<std::uint32_t> faceless;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (has_face[c]) continue;
        faceless.push_back(c);
        if (!one) {
            centres.push_back(grid.origin +
                              grid.size * (cubes.cell[c].cast<double>() + Vec3::Constant(0.5)));
        }
    }
    std::vector<TriangleBvh::Hit> nearest(centres.size());
    if (!centres.empty()) {
        TriangleBvh(mesh).closest(centres, std::numeric_limits<double>::infinity(), nearest);
    }
    for (std::size_t i = 0; i < faceless.size(); ++i) {
        const std::uint16_t m = one ? std::uint16_t{0} : matter.of(nearest[i].triangle);
        deposits.push_back({faceless[i], m, volume[faceless[i]]});
    }
    fill_cubes(cubes, matter.matters, deposits, options);
    return cubes;
}

}  // namespace geometry
