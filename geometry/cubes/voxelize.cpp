#include "geometry/cubes/voxelize.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cells/inside_shares.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/mean_attributes.hpp"
#include "geometry/cubes/pieces.hpp"
#include "geometry/cubes/solid_matter.hpp"
#include "geometry/mesh/doubled_faces.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
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
    constexpr double large = 10;  // m: a unit that is not said is likely
    const double length = most * grid.size;
    throw std::invalid_argument(
        "with cubes of " + short_number(grid.size) + " m the model, " + short_number(length) +
        " m long, exceeds max_cubes = " + std::to_string(options.max_cubes) + "; " +
        (length > large ? "if its file is in centimetres or millimetres, set `unit` of ReadMesh; "
                        : "") +
        "cubes of " + short_number(1.01 * factor * grid.size) + " m would fit, or raise max_cubes");
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

// The same; or one for each piece, where they are to stay apart, of what held(cells) finds there.
template <class Held>
Cubes with_corners(const VoxelGrid& grid, const CellSet& cells, const VoxelOptions& options,
                   const Held& held)
{
    if (options.pieces == NearPieces::merge) return with_corners(grid, cells);
    Cubes cubes = cubes_of_pieces(held(cells.sorted()), grid.size, grid.origin, options.join);
    if (cubes.count() <= options.max_cubes) return cubes;
    throw std::invalid_argument("the model has " + std::to_string(cubes.count()) +
                                " pieces of material in cubes, which exceeds max_cubes = " +
                                std::to_string(options.max_cubes) +
                                ": use larger cubes, raise max_cubes, or set pieces = merge");
}

// A place of a piece of a triangle in a cell: in one quarter with others of it, so in its cube.
Vec3 middle_in(const Polygon& piece, const Vec3i& cell)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < piece.n; ++i) sum += piece.p[i] - cell.cast<double>();
    const Vec3 middle = sum / static_cast<double>(piece.n);
    return cell.cast<double>() + middle.cwiseMax(0.0).cwiseMin(1 - 1e-9);
}

// Face by face.
std::vector<FaceInCube> faces_in_cubes(const LatticeMesh& mesh, const CubeFinder& finder,
                                       double size)
{
    constexpr std::size_t grain = 4096;
    const std::size_t pieces = (mesh.triangles.size() + grain - 1) / grain;
    std::vector<std::vector<FaceInCube>> parts(pieces);
    parallel_for(pieces, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t last = std::min((i + 1) * grain, mesh.triangles.size());
            parts[i].reserve(4 * grain);
            for (std::size_t t = i * grain; t < last; ++t) {
                const auto& [a, b, c] = mesh.triangles[t];
                Polygon triangle;
                for (const std::uint32_t v : {a, b, c}) triangle.add(mesh.positions[v]);
                clip_polygon_to_cells(triangle, [&](const Vec3i& cell, const Polygon& piece) {
                    const double area = piece.area();
                    if (!(area > 0)) return;
                    const std::uint32_t cube = finder.find(middle_in(piece, cell));
                    if (cube == no_index) return;
                    parts[i].push_back({cube, static_cast<std::uint32_t>(t), area * size * size});
                });
            }
        }
    });
    std::vector<FaceInCube> all;
    std::size_t count = 0;
    for (const auto& part : parts) count += part.size();
    all.reserve(count);
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

void require(const LatticeMesh& mesh)
{
    if (mesh.triangles.empty()) {
        throw std::invalid_argument("nothing to voxelize: the mesh has no triangle with finite "
                                    "corners (a point cloud: put Sample before Voxelize)");
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

// Cubes that faces only touch, without area in them, are full of the matter of the nearest face.
void fill_touched(std::vector<Deposit>& deposits, const Cubes& cubes, const TriMesh& mesh,
                  const FaceMatter& matter, double whole)
{
    std::vector<std::uint8_t> held(cubes.count(), 0);
    for (const Deposit& d : deposits) held[d.cube] = 1;
    std::vector<std::uint32_t> bare;
    std::vector<Vec3> centres;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (held[c] != 0) continue;
        bare.push_back(c);
        const Vec3 middle = cubes.cell[c].cast<double>() + Vec3::Constant(0.5);
        centres.push_back(cubes.origin + cubes.size * middle);
    }
    if (bare.empty()) return;
    std::vector<TriangleBvh::Hit> nearest(bare.size());
    TriangleBvh(mesh).closest(centres, std::numeric_limits<double>::infinity(), nearest);
    for (std::size_t i = 0; i < bare.size(); ++i) {
        deposits.push_back({bare[i], matter.of(nearest[i].triangle), whole});
    }
}

// Several sets of samples as one list, each with the matters of all.
struct SampleList {
    std::vector<std::size_t> first{0};  // of each set, and their number
    std::vector<Matter> matters;
    std::vector<std::uint16_t> matter_from;  // of each set, into matters
    std::vector<Vec3> at;                    // in cubes
    std::vector<std::uint8_t> usable;
};

SampleList list_of(std::span<const Samples* const> sets)
{
    SampleList list;
    for (const Samples* set : sets) {
        list.first.push_back(list.first.back() + set->positions.size());
        list.matter_from.push_back(static_cast<std::uint16_t>(list.matters.size()));
        list.matters.insert(list.matters.end(), set->matters.begin(), set->matters.end());
    }
    if (list.matters.size() > 65535) {
        throw std::invalid_argument("the sets of samples have " +
                                    std::to_string(list.matters.size()) +
                                    " materials in all, expected at most 65535: merge some");
    }
    list.at.resize(list.first.back());
    list.usable.resize(list.first.back());
    return list;
}

// The cells that samples lie in; notes where.
CellSet place(std::span<const Samples* const> sets, const VoxelGrid& grid, std::size_t max_cubes,
              SampleList& list)
{
    for (std::size_t k = 0; k < sets.size(); ++k) {
        const std::vector<Vec3f>& positions = sets[k]->positions;
        parallel_for(positions.size(), 16384, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Vec3& at = list.at[list.first[k] + i];
                at = grid.lattice(positions[i]);
                list.usable[list.first[k] + i] =
                    positions[i].allFinite() && at.cwiseAbs().maxCoeff() < CellSet::extent - 1;
            }
        });
    }
    CellSet cells(max_cubes);
    for (std::size_t i = 0; i < list.at.size(); ++i) {
        if (list.usable[i]) cells.insert(cell_of(list.at[i]));
    }
    return cells;
}

// Samples that are full share what the others leave of the volume of their cube.
void fill_rest(std::vector<Deposit>& deposits, std::span<const std::uint8_t> full, double whole,
               std::size_t cubes)
{
    std::vector<double> sum(cubes, 0.0), taken(cubes, 0.0);
    for (std::size_t i = 0; i < deposits.size(); ++i) {
        (full[i] != 0 ? sum : taken)[deposits[i].cube] += deposits[i].volume;
    }
    for (std::size_t i = 0; i < deposits.size(); ++i) {
        const std::uint32_t c = deposits[i].cube;
        if (full[i] != 0) deposits[i].volume *= std::max(0.0, whole - taken[c]) / sum[c];
    }
}

// What each sample fills, set by set; `ends` gets where each set's end.
std::vector<Deposit> deposits_of(std::span<const Samples* const> sets, const SampleList& list,
                                 const CellIndex& index, double whole, std::size_t cubes,
                                 std::vector<std::size_t>& ends)
{
    constexpr double least_volume = 1e-300;  // of a sample without mass, where others count more
    std::vector<Deposit> deposits;
    std::vector<std::uint8_t> full;
    deposits.reserve(list.at.size());
    full.reserve(list.at.size());
    bool any_full = false;
    for (std::size_t k = 0; k < sets.size(); ++k) {
        const Samples& set = *sets[k];
        const bool fills = !(set.bulk > 0);
        any_full |= fills;
        for (std::size_t i = 0; i < set.positions.size(); ++i) {
            const std::size_t n = list.first[k] + i;
            if (!list.usable[n]) continue;
            const std::uint16_t m = set.matter.empty() ? std::uint16_t{0} : set.matter[i];
            const double volume = double(set.mass[i]) / set.matters[m].density;
            deposits.push_back({index.find(cell_of(list.at[n])).begin,
                                static_cast<std::uint16_t>(list.matter_from[k] + m),
                                fills ? std::max(volume, least_volume) : set.bulk * volume});
            full.push_back(fills ? 1 : 0);
        }
        ends.push_back(deposits.size());
    }
    if (any_full) fill_rest(deposits, full, whole, cubes);
    return deposits;
}

double mass_of(std::span<const Deposit> deposits, std::span<const Matter> matters)
{
    double mass = 0;
    for (const Deposit& d : deposits) mass += matters[d.matter].density * d.volume;
    return mass;
}

// Scales the densities of sets that state their mass. Where others leave a set no room at all, its
// samples add that mass in next to no volume.
void keep_masses(std::span<const Samples* const> sets, std::span<Deposit> deposits,
                 std::span<const std::size_t> ends, double whole, SampleList& list)
{
    constexpr double hardly_any = 1e-12;  // of a cube
    for (std::size_t k = 0; k < sets.size(); ++k) {
        const std::size_t begin = k == 0 ? 0 : ends[k - 1];
        const std::span<Deposit> own = deposits.subspan(begin, ends[k] - begin);
        if (!(sets[k]->total_mass > 0) || own.empty()) continue;
        double mass = mass_of(own, list.matters);
        if (!(mass > 0)) {
            const double volume = hardly_any * whole / static_cast<double>(own.size());
            for (Deposit& d : own) d.volume = volume;
            mass = mass_of(own, list.matters);
        }
        for (std::size_t m = 0; m < sets[k]->matters.size(); ++m) {
            list.matters[list.matter_from[k] + m].density *= sets[k]->total_mass / mass;
        }
    }
}

}  // namespace

Cubes voxelize_samples(const Samples& samples, const VoxelGrid& grid, const VoxelOptions& options)
{
    const Samples* const one = &samples;
    return voxelize_samples(std::span(&one, 1), grid, options);
}

Cubes voxelize_samples(std::span<const Samples* const> sets, const VoxelGrid& grid,
                       const VoxelOptions& options)
{
    SampleList list = list_of(sets);
    CellSet cells = within_limit(
        grid, options, [&](const VoxelGrid& g) { return place(sets, g, options.max_cubes, list); });
    if (cells.count() == 0) {
        throw std::invalid_argument("nothing to voxelize: no sample has finite coordinates within "
                                    "2^20 cubes of the origin");
    }
    Cubes cubes = with_corners(grid, cells);
    const CellIndex index(std::move(cells), cubes.cell);
    std::vector<std::size_t> ends;
    std::vector<Deposit> deposits =
        deposits_of(sets, list, index, cube_volume(grid), cubes.count(), ends);
    VoxelOptions asked = options;
    if (sets.size() > 1) {
        keep_masses(sets, deposits, ends, cube_volume(grid), list);
    } else if (asked.total_mass == 0) {
        asked.total_mass = sets[0]->total_mass;
    }
    fill_cubes(cubes, list.matters, deposits, asked);
    add_means_of_samples(cubes, deposits, sets, list.usable);
    return cubes;
}

Cubes voxelize_surface(const TriMesh& mesh, const FaceMatter& matter, double thickness,
                       const VoxelGrid& grid, const VoxelOptions& options)
{
    const LatticeMesh lattice = to_lattice(mesh, grid);
    require(lattice);
    CellSet cells = within_limit(grid, options, [&](const VoxelGrid& g) {
        return surface_cells(g.size == grid.size ? lattice : to_lattice(mesh, g),
                             CellShape::half_open, options.max_cubes);
    });
    Cubes cubes = with_corners(grid, cells, options, [&](std::vector<Vec3i> all) {
        return held_by_surface(snapped_to_quarters(lattice, grid), std::move(all));
    });
    const CubeFinder finder(std::move(cells), cubes);
    std::vector<Deposit> deposits;
    const bool apart = !cubes.part.empty(), full = !(thickness > 0);
    if (full && matter.matters.size() == 1) {
        for (std::uint32_t c = 0; c < cubes.count(); ++c) {
            deposits.push_back({c, 0, cube_volume(grid)});
        }
    } else {
        // Of pieces, as their quarters were found.
        for (const FaceInCube& p : faces_in_cubes(
                 apart ? snapped_to_quarters(lattice, grid) : lattice, finder, grid.size)) {
            deposits.push_back({p.cube, matter.of(lattice.source_of(p.triangle)),
                                p.area * (full ? grid.size : thickness)});
        }
        if (full) {
            scale_to(deposits, std::vector<double>(cubes.count(), cube_volume(grid)),
                     cubes.count());
            fill_touched(deposits, cubes, mesh, matter, cube_volume(grid));
        }
    }
    fill_cubes(cubes, matter.matters, deposits, options);
    return cubes;
}

namespace {

// The volume inside of each cube: whole cubes, but for those that the surface passes through.
// `faces`, unless null: gets what each face has in each cell.
std::vector<double> volumes_inside(const LatticeMesh& lattice, Inside rule, const CellIndex& index,
                                   std::size_t cubes, double whole, std::vector<FaceInCell>* faces)
{
    std::vector<double> volume(cubes, whole);
    const InsideShares border = inside_shares(lattice, rule, faces);
    for (std::size_t i = 0; i < border.cells.size(); ++i) {
        const auto found = index.find(border.cells[i]);
        for (std::uint32_t c = found.begin; c < found.end; ++c) volume[c] = border.share[i] * whole;
    }
    return volume;
}

// A place in quarters of cells, for a mesh that is.
Vec3i quarter_of(const Vec3i& cell, unsigned bit)
{
    return across_cell * cell + Vec3i(static_cast<int>(bit & 3), static_cast<int>(bit >> 2 & 3),
                                      static_cast<int>(bit >> 4));
}

// Shares the volume of each cell out to the cubes in it, by what of their quarters is inside.
void share_out(LatticeMesh lattice, Inside rule, const Cubes& cubes, std::span<double> volume)
{
    for (Vec3& p : lattice.positions) p *= across_cell;
    const bool fits =
        std::all_of(lattice.positions.begin(), lattice.positions.end(),
                    [](const Vec3& p) { return p.cwiseAbs().maxCoeff() < CellSet::extent - 1; });
    const InsideShares border = fits ? inside_shares(lattice, rule) : InsideShares{};
    const CellIndex quarters(border.cells);
    const auto inside = [&](std::size_t c) {
        double sum = 0;
        for (SubCells part = cubes.part[c]; part != 0; part &= part - 1) {
            const auto bit = static_cast<unsigned>(std::countr_zero(part));
            const auto found = quarters.find(quarter_of(cubes.cell[c], bit));
            sum += found ? border.share[found.begin] : 1.0;
        }
        return sum;
    };
    for (std::size_t begin = 0, end = 0; begin < cubes.count(); begin = end) {
        while (end < cubes.count() && cubes.cell[end] == cubes.cell[begin]) ++end;
        if (end == begin + 1) continue;
        double sum = 0;
        for (std::size_t c = begin; c < end; ++c) sum += inside(c);
        for (std::size_t c = begin; c < end; ++c) {
            volume[c] *= sum > 0 ? inside(c) / sum : 1 / static_cast<double>(end - begin);
        }
    }
}

// Those in cubes.
std::vector<FaceInCube> in_cubes(const std::vector<FaceInCell>& faces, const CellIndex& index,
                                 double size)
{
    std::vector<FaceInCube> out;
    out.reserve(faces.size());
    for (const FaceInCell& f : faces) {
        const auto found = index.find(f.cell);
        if (found) out.push_back({found.begin, f.triangle, f.area * size * size});
    }
    return out;
}

// Of sheets with two sides one counts.
void leave_out_backs(std::vector<FaceInCube>& faces, const LatticeMesh& lattice,
                     const DoubledFaces& doubled)
{
    std::erase_if(faces, [&](const FaceInCube& f) {
        return doubled.is[lattice.source_of(f.triangle)] == Doubled::sheet_back;
    });
}

// Sheets of a thickness fill cubes, where that is more.
void thicken(std::span<double> volume, const std::vector<FaceInCube>& faces, double thickness,
             double whole)
{
    std::vector<double> sheet(volume.size(), 0.0);
    for (const FaceInCube& p : faces) sheet[p.cube] += p.area * thickness;
    for (std::size_t c = 0; c < sheet.size(); ++c) {
        volume[c] = std::max(volume[c], std::min(sheet[c], whole));
    }
}

}  // namespace

Cubes voxelize_solid(const TriMesh& mesh, const FaceMatter& matter, Inside rule, double thickness,
                     const VoxelGrid& grid, const VoxelOptions& options)
{
    const SolidFaces solid = solid_faces(mesh, matter.face);
    LatticeMesh lattice = to_lattice(mesh, solid, grid);
    require(lattice);
    CellSet cells = within_limit(grid, options, [&](const VoxelGrid& g) {
        return solid_cells(g.size == grid.size ? lattice : to_lattice(mesh, solid, g), rule,
                           options.max_cubes);
    });
    Cubes cubes = with_corners(grid, cells, options, [&](std::vector<Vec3i> all) {
        return held_by_solid(snapped_to_quarters(lattice, grid), rule, std::move(all));
    });
    const CellIndex index(std::move(cells), cubes.cell);
    const double whole = cube_volume(grid);
    const bool one = matter.matters.size() == 1, needs_faces = !one || thickness > 0;
    const bool apart = !cubes.part.empty();
    std::vector<FaceInCell> pieces;
    std::vector<double> volume = volumes_inside(lattice, rule, index, cubes.count(), whole,
                                                needs_faces && !apart ? &pieces : nullptr);
    std::vector<FaceInCube> faces = in_cubes(pieces, index, grid.size);
    if (apart) {
        const LatticeMesh snapped = snapped_to_quarters(lattice, grid);
        share_out(snapped, rule, cubes, volume);
        if (needs_faces) faces = faces_in_cubes(snapped, CubeFinder(cubes), grid.size);
    }
    if (thickness > 0) {
        leave_out_backs(faces, lattice, doubled_faces(mesh, matter.face));
        thicken(volume, faces, thickness, whole);
    }
    std::vector<Deposit> deposits;
    if (one) {
        for (std::uint32_t c = 0; c < cubes.count(); ++c) deposits.push_back({c, 0, volume[c]});
    } else {
        deposits = matter_of_solid({mesh, lattice, matter, rule, thickness}, cubes, faces, volume);
    }
    fill_cubes(cubes, matter.matters, deposits, options);
    return cubes;
}

}  // namespace geometry
