// Parts, in the order of a run:
//   sample_block .. find_vertices   each block by itself: corners, patterns, a vertex a sheet
//   number_blocks                   where each block's vertices and quads go in the mesh
//   for_quads, write_triangles      the quads between blocks' vertices, cut in two
//   too_many_triangles              what to say where they do not fit

#include "geometry/fields/polygonize.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/fields/cell_patterns.hpp"
#include "geometry/fields/iso_grid.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

constexpr int block_points = block_cells + 1;

// A vertex starts from the mean of its sheet's crossings, drawn this far towards the cell's centre:
// sheets that cut a mere corner off their cells would else start, and end, in one place. On twelve
// blended balls (140k triangles) the worst shape, 4 sqrt(3) area / sum of squared edges, rises from
// 0 to above 0.2, the mean from 0.879 to 0.883; drawn all the way there would be folds.
constexpr double towards_centre = 0.2;

// A block of the grid that the surface may cross, and what was found in it.
struct Block {
    Vec3i at = Vec3i::Zero();  // in blocks
    std::uint32_t first_vertex = 0;
    // Empty when the surface does not come by:
    std::vector<std::uint8_t> pattern;  // block_cells^3
    std::vector<std::uint8_t> cut;      // block_cells^3, which way the troublesome face goes
    std::vector<std::uint16_t> first;   // block_cells^3, the cell's first vertex in the block
    std::vector<Vec3f> positions, normals;
};

std::size_t cell_number(int x, int y, int z)
{
    return static_cast<std::size_t>(x + block_cells * (y + block_cells * z));
}

std::size_t point_number(int x, int y, int z)
{
    return static_cast<std::size_t>(x + block_points * (y + block_points * z));
}

// Whether the cell's troublesome face is one for its neighbour across it, too.
bool troubles_both(const IsoGrid& grid, const Vec3i& cell, unsigned pattern, std::uint8_t face)
{
    const int d = face / 2, s = face % 2;
    FieldBlock far;
    std::array<int, 4> corner_of{};
    for (int corner = 0; corner < 8; ++corner) {
        if ((corner >> d & 1) != s) continue;
        corner_of[far.count] = corner;
        const Vec3i at = cell + Vec3i(corner & 1, corner >> 1 & 1, corner >> 2);
        far.add(grid.point(at + (s ? 1 : -1) * Vec3i::Unit(d)));
    }
    far.pad();
    BlockValues values;
    grid.field.ask(far, values);
    unsigned neighbour = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const int shared = corner_of[i] ^ 1 << d;  // the same point, as the neighbour numbers it
        if (pattern >> corner_of[i] & 1) neighbour |= 1u << shared;
        if (values.f[i] >= 0) neighbour |= 1u << corner_of[i];
    }
    return cell_patterns().troublesome[neighbour] == (face ^ 1);
}

using BlockCorners = std::array<double, block_points * block_points * block_points>;

// The field at the corners of a block's cells.
void sample_block(const IsoGrid& grid, const Vec3i& base, BlockCorners& f)
{
    thread_local FieldBlock points;
    thread_local BlockValues values;
    for (int z = 0, filled = 0; z < block_points;) {
        points.count = 0;
        for (; z < block_points && points.count + 81 <= FieldBlock::capacity; ++z) {
            for (int y = 0; y < block_points; ++y) {
                for (int x = 0; x < block_points; ++x)
                    points.add(grid.point(base + Vec3i(x, y, z)));
            }
        }
        points.pad();
        grid.field.ask(points, values);
        std::copy_n(values.f, points.count, f.begin() + filled);
        filled += static_cast<int>(points.count);
    }
}

// The sheets of one cell: where each crosses the cell's edges, on average.
struct SheetMeans {
    std::array<Vec3, 4> sum;  // of crossings, in the cell, 0..1
    std::array<int, 4> crossings{};
};

SheetMeans means_of(const CellSheets& sheets, const std::array<double, 8>& corner)
{
    const CellPatterns& table = cell_patterns();
    SheetMeans means;
    means.sum.fill(Vec3::Zero());
    for (std::size_t e = 0; e < 12; ++e) {
        const std::uint8_t sheet = sheets.of_edge[e];
        if (sheet == no_sheet) continue;
        const auto [a, b] = table.edge_corners[e];
        const double t = corner[a] / (corner[a] - corner[b]);
        Vec3 at(a & 1, a >> 1 & 1, a >> 2);
        at[static_cast<Eigen::Index>(e / 4)] = std::isfinite(t) ? t : 0.5;
        means.sum[sheet] += at;
        ++means.crossings[sheet];
    }
    return means;
}

// Vertices on their way to the surface, and the lowest corner of the box that each stays in.
struct Vertices {
    std::vector<Vec3> at, low;
};

// Takes up cell (x, y, z) of a block: its pattern, and a vertex for each sheet.
void add_cell(const IsoGrid& grid, const Vec3i& at, const BlockCorners& f, Block& block,
              Vertices& vertices)
{
    std::array<double, 8> corner;
    unsigned pattern = 0;
    for (unsigned a = 0; a < 8; ++a) {
        const auto i = static_cast<int>(a);
        corner[a] = f[point_number(at.x() + (i & 1), at.y() + (i >> 1 & 1), at.z() + (i >> 2))];
        pattern |= static_cast<unsigned>(corner[a] >= 0) << a;
    }
    if (pattern == 0 || pattern == 255) return;
    if (block.pattern.empty()) {
        block.pattern.assign(block_cells * block_cells * block_cells, 0);
        block.cut.assign(block.pattern.size(), 0);
        block.first.assign(block.pattern.size(), 0);
    }
    const CellPatterns& table = cell_patterns();
    const std::size_t number = cell_number(at.x(), at.y(), at.z());
    const Vec3i cell = block_cells * block.at + at;
    const std::uint8_t face = table.troublesome[pattern];
    const bool cut = face != no_face && troubles_both(grid, cell, pattern, face);
    block.pattern[number] = static_cast<std::uint8_t>(pattern);
    block.cut[number] = cut;
    block.first[number] = static_cast<std::uint16_t>(vertices.at.size());

    const CellSheets& sheets = table.sheets[pattern][cut];
    const SheetMeans means = means_of(sheets, corner);
    for (std::size_t s = 0; s < sheets.count; ++s) {
        const Vec3 within = (1 - towards_centre) / means.crossings[s] * means.sum[s] +
                            Vec3::Constant(0.5 * towards_centre);
        vertices.at.push_back(grid.cell * (cell.cast<double>() + within));
        vertices.low.push_back(grid.point(cell).array() - 0.5 * grid.cell);
    }
}

// All vertices of a block, moved onto the surface.
void find_vertices(const IsoGrid& grid, Block& block)
{
    const Vec3i base = block_cells * block.at;
    thread_local BlockCorners f;
    thread_local Vertices vertices;
    sample_block(grid, base, f);
    vertices.at.clear();
    vertices.low.clear();
    const Vec3i begin = (grid.lo - base).cwiseMax(0);
    const Vec3i end = (grid.hi - base).cwiseMin(block_cells);
    for (int z = begin.z(); z < end.z(); ++z) {
        for (int y = begin.y(); y < end.y(); ++y) {
            for (int x = begin.x(); x < end.x(); ++x) add_cell(grid, {x, y, z}, f, block, vertices);
        }
    }
    // Never further than half a cell out of their own cell, so that no face folds over.
    block.positions.resize(vertices.at.size());
    block.normals.resize(vertices.at.size());
    onto_surface(grid.field, vertices.at, vertices.low, 2 * grid.cell, block.positions,
                 block.normals);
}

const Block* find_block(const std::vector<Block>& blocks, const Vec3i& at)
{
    const auto found =
        std::lower_bound(blocks.begin(), blocks.end(), at, [](const Block& block, const Vec3i& b) {
            return block_before(block.at, b);
        });
    return found != blocks.end() && found->at == at && !found->pattern.empty() ? &*found : nullptr;
}

// The quads of all crossed grid edges that start at the block's own points.
template <class Emit>
void for_quads(const std::vector<Block>& blocks, const Block& block, const Emit& emit)
{
    const CellPatterns& table = cell_patterns();
    std::array<const Block*, 8> lower{};  // the blocks one back along the axes of the bits
    for (int c = 0; c < 8; ++c) {
        lower[static_cast<std::size_t>(c)] =
            c == 0 ? &block : find_block(blocks, block.at - Vec3i(c & 1, c >> 1 & 1, c >> 2));
    }
    for (int z = 0; z < block_cells; ++z) {
        for (int y = 0; y < block_cells; ++y) {
            for (int x = 0; x < block_cells; ++x) {
                const unsigned pattern = block.pattern[cell_number(x, y, z)];
                if (pattern == 0 || pattern == 255) continue;
                for (int d = 0; d < 3; ++d) {
                    const bool inside = pattern & 1;
                    if (inside == (pattern >> (1 << d) & 1)) continue;
                    const int u = (d + 1) % 3, v = (d + 2) % 3;
                    constexpr int du[] = {-1, 0, 0, -1}, dv[] = {-1, -1, 0, 0};
                    std::array<std::uint32_t, 4> quad{};
                    bool whole = true;
                    for (std::size_t q = 0; q < 4 && whole; ++q) {
                        Vec3i at(x, y, z);
                        at[u] += du[q];
                        at[v] += dv[q];
                        std::size_t from = 0;
                        for (int axis = 0; axis < 3; ++axis) {
                            if (at[axis] >= 0) continue;
                            at[axis] += block_cells;
                            from |= std::size_t{1} << axis;
                        }
                        const Block* owner = lower[from];
                        const std::size_t number = cell_number(at.x(), at.y(), at.z());
                        whole = owner != nullptr;
                        if (!whole) break;
                        const unsigned there = owner->pattern[number];
                        const auto edge =
                            static_cast<std::size_t>(4 * d + (du[q] ? 1 : 0) + (dv[q] ? 2 : 0));
                        const std::uint8_t sheet =
                            table.sheets[there][owner->cut[number]].of_edge[edge];
                        whole = sheet != no_sheet;
                        quad[q] = owner->first_vertex + owner->first[number] + sheet;
                    }
                    if (!whole) continue;
                    if (!inside) std::swap(quad[1], quad[3]);
                    emit(quad);
                }
            }
        }
    }
}

// Where each block's vertices and quads begin in the mesh. Sets the former in the blocks.
struct Numbers {
    std::uint64_t vertices = 0;
    std::vector<std::uint32_t> quads;  // blocks + 1
};

Numbers number_blocks(std::vector<Block>& blocks)
{
    Numbers numbers;
    for (Block& block : blocks) {
        block.first_vertex = static_cast<std::uint32_t>(numbers.vertices);
        numbers.vertices += block.positions.size();
    }
    std::vector<std::uint32_t>& quads = numbers.quads;
    quads.assign(blocks.size() + 1, 0);
    parallel_for(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            for_quads(blocks, blocks[b], [&](const auto&) { ++quads[b + 1]; });
        }
    });
    for (std::size_t b = 0; b < blocks.size(); ++b) quads[b + 1] += quads[b];
    return numbers;
}

// A block's quads as triangles, from `out` on, each cut along its shorter diagonal.
void write_triangles(const std::vector<Block>& blocks, const Block& block,
                     std::span<const Vec3f> positions, Triangle* out)
{
    for_quads(blocks, block, [&](const std::array<std::uint32_t, 4>& q) {
        const auto length_sq = [&](std::size_t i, std::size_t j) {
            return (positions[q[i]] - positions[q[j]]).squaredNorm();
        };
        if (length_sq(0, 2) <= length_sq(1, 3)) {
            *out++ = {q[0], q[1], q[2]};
            *out++ = {q[0], q[2], q[3]};
        } else {
            *out++ = {q[1], q[2], q[3]};
            *out++ = {q[1], q[3], q[0]};
        }
    });
}

TriMesh join_blocks(std::vector<Block>& blocks)
{
    const Numbers numbers = number_blocks(blocks);
    TriMesh mesh;
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles.resize(2 * std::size_t{numbers.quads.back()});
    mesh.positions.resize(numbers.vertices);
    mesh.normals.resize(numbers.vertices);
    parallel_for(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const auto at = static_cast<std::ptrdiff_t>(blocks[b].first_vertex);
            std::copy(blocks[b].positions.begin(), blocks[b].positions.end(),
                      mesh.positions.begin() + at);
            std::copy(blocks[b].normals.begin(), blocks[b].normals.end(),
                      mesh.normals.begin() + at);
        }
    });
    parallel_for(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            write_triangles(blocks, blocks[b], mesh.positions,
                            topology->triangles.data() + 2 * std::size_t{numbers.quads[b]});
        }
    });
    topology->normal_triangles = topology->triangles;
    mesh.topology = std::move(topology);
    return mesh;
}

TriMesh mesh_on(const IsoGrid& grid)
{
    if (grid.field.domain.empty()) return {};
    std::vector<Block> blocks;
    for (const Vec3i& at : crossed_blocks(grid)) blocks.emplace_back().at = at;
    std::atomic<std::size_t> found = 0;  // vertices, of which a mesh has half as many as triangles
    std::atomic<bool> too_many = false;
    const auto find_some = [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end && !too_many; ++b) {
            find_vertices(grid, blocks[b]);
            const std::size_t here = blocks[b].positions.size();
            if (found.fetch_add(here) + here > grid.max_triangles / 2) too_many = true;
        }
    };
    parallel_for(blocks.size(), 4, find_some);
    if (too_many) {
        blocks = {};
        throw TooManyTriangles();
    }
    std::erase_if(blocks, [](const Block& block) { return block.pattern.empty(); });
    return join_blocks(blocks);
}

}  // namespace

std::invalid_argument too_many_triangles(const IsoField& field, double cell,
                                         std::size_t max_triangles)
{
    // As fine as is quick; triangles go as the square of the cells' edge.
    const double coarse = std::max(cell, field.domain.size().maxCoeff() / 64);
    const auto count = static_cast<double>(polygonize(field, coarse, unlimited).triangles().size());
    const double fits = 1.05 * coarse * std::sqrt(count / static_cast<double>(max_triangles));
    if (!(fits > cell)) {  // all of it too thin for coarse cells
        return std::invalid_argument(fmt::format("cell = {:g} m gives more triangles than "
                                                 "max_triangles = {}. Use larger cells, or raise "
                                                 "max_triangles.",
                                                 cell, max_triangles));
    }
    return std::invalid_argument(
        fmt::format("cell = {:g} m gives about {:.2g} triangles, more than max_triangles = {}. Use "
                    "cells of {:.2g} m, or raise max_triangles.",
                    cell, count * std::pow(coarse / cell, 2), max_triangles, fits));
}

TriMesh polygonize(const IsoField& field, double cell, std::size_t max_triangles)
{
    max_triangles = std::min(max_triangles, unlimited);
    try {
        return mesh_on(iso_grid(field, cell, max_triangles));
    } catch (const TooManyTriangles&) {
        throw too_many_triangles(field, cell, max_triangles);
    }
}

}  // namespace geometry
