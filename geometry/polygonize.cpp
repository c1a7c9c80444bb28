#include "geometry/polygonize.hpp"

#include "geometry/iso_grid.hpp"
#include "geometry/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

constexpr int block_points = block_cells + 1;
constexpr std::uint8_t none = 0xff;

// A vertex starts from the mean of its sheet's crossings, drawn this far towards the cell's centre:
// sheets that cut a mere corner off their cells would else start, and end, in one place. On twelve
// blended balls (140k triangles) the worst shape, 4 sqrt(3) area / sum of squared edges, rises from
// 0 to above 0.2, the mean from 0.879 to 0.883; drawn all the way there would be folds.
constexpr double towards_centre = 0.2;

// Corner a of a cell lies at ((a & 1), (a >> 1 & 1), (a >> 2 & 1)). Edge 4 d + i runs along axis d.
// Face 2 d + s is the one across axis d on side s.
struct Patterns {
    struct Sheets {
        std::uint8_t count = 0;
        std::array<std::uint8_t, 12> of_edge{};  // which sheet crosses it, `none`: no crossing
    };
    std::array<std::array<std::uint8_t, 2>, 12> edge_corners{};
    std::array<std::array<Sheets, 2>, 256> sheets;  // by pattern of inside corners; [1]: the
                                                    // troublesome face cut the other way
    std::array<std::uint8_t, 256> troublesome{};    // the face, or `none`

    Patterns()
    {
        for (int d = 0; d < 3; ++d) {
            for (int i = 0; i < 4; ++i) {
                const int lo = (i & 1) << (d + 1) % 3 | (i >> 1) << (d + 2) % 3;
                edge_corners[static_cast<std::size_t>(4 * d + i)] = {
                    static_cast<std::uint8_t>(lo), static_cast<std::uint8_t>(lo | 1 << d)};
            }
        }
        for (unsigned pattern = 0; pattern < 256; ++pattern) {
            troublesome[pattern] = none;
            sheets[pattern][0] = trace(pattern, none);
            for (std::uint8_t face = 0; face < 6; ++face) {
                if (crossings(pattern, face) == 4 && one_sheet(sheets[pattern][0], face)) {
                    troublesome[pattern] = face;
                }
            }
            sheets[pattern][1] = trace(pattern, troublesome[pattern]);
        }
    }

    // Corners of a face, counter-clockwise seen from outside the cell.
    static std::array<int, 4> ring(std::uint8_t face)
    {
        const int d = face / 2, s = face % 2;
        const int u = 1 << (d + 1) % 3, v = 1 << (d + 2) % 3, base = s << d;
        return s ? std::array{base, base | u, base | u | v, base | v}
                 : std::array{base, base | v, base | u | v, base | u};
    }

    std::uint8_t edge_between(int a, int b) const
    {
        for (std::uint8_t e = 0; e < 12; ++e) {
            if (edge_corners[e][0] == std::min(a, b) && edge_corners[e][1] == std::max(a, b)) {
                return e;
            }
        }
        return none;
    }

    static int crossings(unsigned pattern, std::uint8_t face)
    {
        const auto corners = ring(face);
        int count = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            count += (pattern >> corners[i] & 1) != (pattern >> corners[(i + 1) % 4] & 1);
        }
        return count;
    }

    bool one_sheet(const Sheets& traced, std::uint8_t face) const
    {
        const auto corners = ring(face);
        return traced.of_edge[edge_between(corners[0], corners[1])] ==
                   traced.of_edge[edge_between(corners[1], corners[2])] &&
               traced.of_edge[edge_between(corners[1], corners[2])] ==
                   traced.of_edge[edge_between(corners[2], corners[3])];
    }

    // Each face gives curves from a crossing where its ring leaves the inside to one where it
    // enters it: to the last such before (cutting off the inside corners between them) or, on
    // `other_way`, the next after. Chained from face to face they close into the sheets' borders.
    Sheets trace(unsigned pattern, std::uint8_t other_way) const
    {
        std::array<std::uint8_t, 12> next;
        next.fill(none);
        for (std::uint8_t face = 0; face < 6; ++face) {
            const auto corners = ring(face);
            const auto inside = [&](std::size_t i) { return pattern >> corners[i % 4] & 1; };
            for (std::size_t i = 0; i < 4; ++i) {
                if (!inside(i) || inside(i + 1)) continue;
                std::size_t j = i;
                if (face == other_way) {
                    while (inside(j) || !inside(j + 1)) ++j;
                } else {
                    while (inside(j) || !inside(j + 1)) j += 3;
                }
                next[edge_between(corners[i % 4], corners[(i + 1) % 4])] =
                    edge_between(corners[j % 4], corners[(j + 1) % 4]);
            }
        }
        Sheets traced;
        traced.of_edge.fill(none);
        for (std::uint8_t e = 0; e < 12; ++e) {
            if (next[e] == none || traced.of_edge[e] != none) continue;
            for (std::uint8_t x = e; traced.of_edge[x] == none; x = next[x]) {
                traced.of_edge[x] = traced.count;
            }
            ++traced.count;
        }
        return traced;
    }
};

const Patterns& patterns()
{
    static const Patterns table;
    return table;
}

// A block of the grid that the surface may cross, and what was found in it.
struct Block {
    Vec3i at = Vec3i::Zero();  // in blocks
    std::uint32_t first_vertex = 0;
    std::uint32_t first_quad = 0;
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
    return patterns().troublesome[neighbour] == (face ^ 1);
}

void find_vertices(const IsoGrid& grid, Block& block)
{
    const Vec3i base = block_cells * block.at;
    thread_local std::array<double, block_points * block_points * block_points> f;
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

    thread_local std::vector<Vec3> vertices, low;  // low: how far each may go
    vertices.clear();
    low.clear();
    const Patterns& table = patterns();
    const auto range = [&](int axis) {
        return std::pair(std::max(0, grid.lo[axis] - base[axis]),
                         std::min(block_cells, grid.hi[axis] - base[axis]));
    };
    const auto [x0, x1] = range(0);
    const auto [y0, y1] = range(1);
    const auto [z0, z1] = range(2);
    for (int z = z0; z < z1; ++z) {
        for (int y = y0; y < y1; ++y) {
            for (int x = x0; x < x1; ++x) {
                std::array<double, 8> corner;
                unsigned pattern = 0;
                for (unsigned a = 0; a < 8; ++a) {
                    const auto i = static_cast<int>(a);
                    corner[a] = f[point_number(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2))];
                    pattern |= static_cast<unsigned>(corner[a] >= 0) << a;
                }
                if (pattern == 0 || pattern == 255) continue;
                if (block.pattern.empty()) {
                    block.pattern.assign(block_cells * block_cells * block_cells, 0);
                    block.cut.assign(block.pattern.size(), 0);
                    block.first.assign(block.pattern.size(), 0);
                }
                const std::size_t number = cell_number(x, y, z);
                const Vec3i cell = base + Vec3i(x, y, z);
                const std::uint8_t face = table.troublesome[pattern];
                const bool cut = face != none && troubles_both(grid, cell, pattern, face);
                block.pattern[number] = static_cast<std::uint8_t>(pattern);
                block.cut[number] = cut;
                block.first[number] = static_cast<std::uint16_t>(vertices.size());

                const Patterns::Sheets& sheets = table.sheets[pattern][cut];
                std::array<Vec3, 4> sum;
                std::array<int, 4> crossings{};
                sum.fill(Vec3::Zero());
                for (std::size_t e = 0; e < 12; ++e) {
                    const std::uint8_t sheet = sheets.of_edge[e];
                    if (sheet == none) continue;
                    const auto [a, b] = table.edge_corners[e];
                    const double t = corner[a] / (corner[a] - corner[b]);
                    Vec3 at(a & 1, a >> 1 & 1, a >> 2);
                    at[static_cast<Eigen::Index>(e / 4)] = std::isfinite(t) ? t : 0.5;
                    sum[sheet] += at;
                    ++crossings[sheet];
                }
                for (std::size_t s = 0; s < sheets.count; ++s) {
                    const Vec3 within = (1 - towards_centre) / crossings[s] * sum[s] +
                                        Vec3::Constant(0.5 * towards_centre);
                    vertices.push_back(grid.cell * (cell.cast<double>() + within));
                    low.push_back(grid.point(cell).array() - 0.5 * grid.cell);
                }
            }
        }
    }
    // Never further than half a cell out of their own cell, so that no face folds over.
    block.positions.resize(vertices.size());
    block.normals.resize(vertices.size());
    onto_surface(grid.field, vertices, low, 2 * grid.cell, block.positions, block.normals);
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
    const Patterns& table = patterns();
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
                        whole = sheet != none;
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

}  // namespace

IsoField iso_field(const Field& field)
{
    IsoField iso;
    iso.domain = influence(field);
    iso.bounds = [&field](const Box& box) {
        thread_local std::vector<std::uint32_t> near;
        candidates(field, box, near);
        const Interval range = bounds(field, near, box);
        return Interval{range.lo - field.isovalue, range.hi - field.isovalue};
    };
    iso.ask = [&field](const FieldBlock& block, BlockValues& values) {
        thread_local std::vector<std::uint32_t> near;
        thread_local FieldScratch scratch;
        Box box;
        for (std::size_t i = 0; i < block.count; ++i) box.add(block.point(i));
        candidates(field, box, near);
        evaluate(field, near, block, scratch, values);
        for (std::size_t i = 0; i < block.count; ++i) values.f[i] -= field.isovalue;
    };
    return iso;
}

std::invalid_argument too_many_triangles(const IsoField& field, double cell,
                                         std::size_t max_triangles)
{
    // As fine as is quick; triangles go as the square of the cells' edge.
    const double coarse = std::max(cell, field.domain.size().maxCoeff() / 64);
    const auto count = static_cast<double>(polygonize(field, coarse, unlimited).triangles().size());
    const double fits = 1.05 * coarse * std::sqrt(count / static_cast<double>(max_triangles));
    if (!(fits > cell)) {  // all of it too thin for coarse cells
        return std::invalid_argument(fmt::format(
            "cells of {:g} m give more than max_triangles = {}; use larger cells, or raise it",
            cell, max_triangles));
    }
    return std::invalid_argument(
        fmt::format("cells of {:g} m give about {:.2g} triangles, more than max_triangles = {}; "
                    "cells of {:.2g} m would fit, or raise max_triangles",
                    cell, count * std::pow(coarse / cell, 2), max_triangles, fits));
}

static TriMesh mesh_on(const IsoGrid& grid)
{
    TriMesh mesh;
    if (grid.field.domain.empty()) return mesh;
    std::vector<Block> blocks;
    for (const Vec3i& at : crossed_blocks(grid)) blocks.emplace_back().at = at;
    std::atomic<std::size_t> found = 0;  // vertices, of which a mesh has half as many as triangles
    std::atomic<bool> too_many = false;
    parallel_for(blocks.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end && !too_many; ++b) {
            find_vertices(grid, blocks[b]);
            const std::size_t here = blocks[b].positions.size();
            if (found.fetch_add(here) + here > grid.max_triangles / 2) too_many = true;
        }
    });
    if (too_many) {
        blocks = {};
        throw TooManyTriangles();
    }
    std::erase_if(blocks, [](const Block& block) { return block.pattern.empty(); });

    std::uint64_t vertices = 0;
    for (Block& block : blocks) {
        block.first_vertex = static_cast<std::uint32_t>(vertices);
        vertices += block.positions.size();
    }
    std::vector<std::uint32_t> quads(blocks.size() + 1, 0);
    parallel_for(blocks.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            for_quads(blocks, blocks[b], [&](const auto&) { ++quads[b + 1]; });
        }
    });
    for (std::size_t b = 0; b < blocks.size(); ++b) quads[b + 1] += quads[b];
    const std::size_t quad_count = quads.back();

    auto topology = std::make_shared<MeshTopology>();
    topology->triangles.resize(2 * quad_count);
    mesh.positions.resize(vertices);
    mesh.normals.resize(vertices);
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
            Triangle* out = topology->triangles.data() + 2 * std::size_t{quads[b]};
            for_quads(blocks, blocks[b], [&](const std::array<std::uint32_t, 4>& q) {
                const auto length_sq = [&](std::size_t i, std::size_t j) {
                    return (mesh.positions[q[i]] - mesh.positions[q[j]]).squaredNorm();
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
    });
    topology->normal_triangles = topology->triangles;
    mesh.topology = std::move(topology);
    return mesh;
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
