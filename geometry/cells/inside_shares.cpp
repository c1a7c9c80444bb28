#include "geometry/cells/inside_shares.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cells/cell_lines.hpp"
#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace geometry {
namespace {

// Of the faces in a cell: their area seen along an axis, and its moment about the cell's lower
// side.
struct Seen {
    double area = 0, moment = 0;
};

Seen seen_along(int axis, const Vec3i& cell, const Polygon& piece)
{
    const int v = (axis + 1) % 3, w = (axis + 2) % 3;
    Seen seen;
    for (std::size_t i = 2; i < piece.n; ++i) {
        const Vec3 &a = piece.p[0], &b = piece.p[i - 1], &c = piece.p[i];
        const double area = 0.5 * ((b[v] - a[v]) * (c[w] - a[w]) - (b[w] - a[w]) * (c[v] - a[v]));
        seen.area += area;
        seen.moment += area * ((a[axis] + b[axis] + c[axis]) / 3 - cell[axis]);
    }
    return seen;
}

// Sums over the faces in each cell, for the first so many axes: [axis][cell]. In the order of the
// faces, whatever the number of threads. `faces`, unless null: gets all of them.
std::array<std::vector<Seen>, 3> faces_seen(const LatticeMesh& mesh, const CellIndex& index,
                                            std::size_t cells, int axes,
                                            std::vector<FaceInCell>* faces)
{
    struct Piece {
        std::uint32_t cell;
        std::array<Seen, 3> seen;
    };
    constexpr std::size_t grain = 1024, parts = 64;  // triangles a part, parts at a time
    std::array<std::vector<Seen>, 3> sums;
    for (int k = 0; k < axes; ++k) sums[static_cast<std::size_t>(k)].resize(cells);
    std::array<std::vector<Piece>, parts> pieces;
    std::array<std::vector<FaceInCell>, parts> faces_of;
    const std::size_t n = mesh.triangles.size();
    for (std::size_t start = 0; start < n; start += grain * parts) {
        stop_if_asked();
        parallel_for(parts, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t part = begin; part < end; ++part) {
                pieces[part].clear();
                faces_of[part].clear();
                const std::size_t first = start + part * grain;
                for (std::size_t t = first; t < std::min(n, first + grain); ++t) {
                    Polygon triangle;
                    for (const std::uint32_t v : mesh.triangles[t]) {
                        triangle.add(mesh.positions[v]);
                    }
                    clip_polygon_to_cells(triangle, [&](const Vec3i& cell, const Polygon& piece) {
                        const double area = faces ? piece.area() : 0;
                        if (area > 0) {
                            faces_of[part].push_back({cell, static_cast<std::uint32_t>(t), area});
                        }
                        const auto found = index.find(cell);
                        if (!found) return;
                        Piece& added = pieces[part].emplace_back();
                        added.cell = found.begin;
                        for (int k = 0; k < axes; ++k) {
                            added.seen[static_cast<std::size_t>(k)] = seen_along(k, cell, piece);
                        }
                    });
                }
            }
        });
        for (const std::vector<Piece>& part : pieces) {
            for (const Piece& piece : part) {
                for (std::size_t k = 0; k < static_cast<std::size_t>(axes); ++k) {
                    Seen& sum = sums[k][piece.cell];
                    sum.area += piece.seen[k].area;
                    sum.moment += piece.seen[k].moment;
                }
            }
        }
        for (const auto& some : faces_of) {
            if (faces) faces->insert(faces->end(), some.begin(), some.end());
        }
    }
    return sums;
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// The volume in each cell by the columns along an axis; unknown in rows whose faces do not close.
std::vector<double> volumes_along(int axis, std::span<const Vec3i> cells,
                                  std::span<const Seen> seen)
{
    const int v = (axis + 1) % 3, w = (axis + 2) % 3;
    std::vector<std::uint32_t> order(cells.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto key = [&](std::uint32_t i) {
        return std::tuple(cells[i][w], cells[i][v], cells[i][axis]);
    };
    if (axis != 0) {
        std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
    }
    std::vector<double> volumes(cells.size(), unknown);
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        double total = 0, size = 1;
        const Vec3i& row = cells[order[begin]];
        for (; end < order.size(); ++end) {
            const Vec3i& cell = cells[order[end]];
            if (cell[v] != row[v] || cell[w] != row[w]) break;
            total += seen[order[end]].area;
            size += std::abs(seen[order[end]].area);
        }
        if (!(std::abs(total) < 1e-9 * size)) continue;
        double beyond = 0;
        for (std::size_t i = end; i-- > begin;) {
            volumes[order[i]] = seen[order[i]].moment + beyond;
            beyond += seen[order[i]].area;
        }
    }
    return volumes;
}

// Whole cells are to be whole, whatever rounding does.
double snapped(double share)
{
    constexpr double round_off = 1e-9;
    return share < round_off ? 0 : share > 1 - round_off ? 1 : share;
}

bool agree(double a, double b)
{
    return std::abs(a - b) < 1e-6;
}

// The triangles that lines along an axis through these cells can meet.
LatticeMesh in_rows_of(std::span<const Vec3i> cells, int axis, const LatticeMesh& mesh)
{
    const int v = (axis + 1) % 3, w = (axis + 2) % 3;
    CellSet rows;
    for (const Vec3i& c : cells) rows.insert({c[v], c[w], 0});
    LatticeMesh out;
    out.positions = mesh.positions;
    out.closed = mesh.closed;  // in these rows
    for (const Triangle& t : mesh.triangles) {
        const Vec3 &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        const Vec3i lo = cell_of(a.cwiseMin(b).cwiseMin(c)),
                    hi = cell_of(a.cwiseMax(b).cwiseMax(c));
        constexpr int large = 8;  // cells: not looked at closer
        bool meets = hi[v] - lo[v] > large || hi[w] - lo[w] > large;
        for (int j = lo[w]; j <= hi[w] && !meets; ++j) {
            for (int i = lo[v]; i <= hi[v] && !meets; ++i) meets = rows.contains({i, j, 0});
        }
        if (meets) out.triangles.push_back(t);
    }
    return out;
}

// The cell's volume where the columns along one axis, or two of three, say the same.
double by_columns(const std::array<std::vector<double>, 3>& volumes, std::size_t c)
{
    if (volumes[1].empty()) return std::abs(volumes[0][c]);
    const double x = volumes[0][c], y = volumes[1][c], z = volumes[2][c];
    return std::abs(agree(x, y) || agree(x, z) ? x : agree(y, z) ? y : unknown);
}

}  // namespace

InsideShares inside_shares(const LatticeMesh& mesh, Inside rule, std::vector<FaceInCell>* faces)
{
    InsideShares out;
    CellSet set = surface_cells(mesh, CellShape::half_open);
    out.cells = set.sorted();
    const CellIndex index(std::move(set), out.cells);
    const bool closed = is_closed(mesh);
    const bool one_axis = closed && rule == Inside::winding;

    const int axes = closed ? 1 : 3;
    const auto seen = faces_seen(mesh, index, out.cells.size(), axes, faces);
    std::array<std::vector<double>, 3> volumes;
    for (int k = 0; k < axes; ++k) {
        const auto axis = static_cast<std::size_t>(k);
        volumes[axis] = volumes_along(k, out.cells, seen[axis]);
    }

    CellLines lines =
        one_axis ? cell_lines_along(0, mesh, rule, out.cells) : cell_lines(mesh, rule, out.cells);
    // Walls that lines along x run past may be doubled. (Corners that they run past are smaller.)
    constexpr double least_wall = 0.04;
    std::vector<std::uint32_t> walls;
    std::vector<Vec3i> wall_cells;
    for (std::uint32_t c = 0; c < out.cells.size() && one_axis; ++c) {
        if (lines.windings[c] != 0 || !(by_columns(volumes, c) > least_wall)) continue;
        walls.push_back(c);
        wall_cells.push_back(out.cells[c]);
    }
    for (int axis = 1; axis < 3 && !walls.empty(); ++axis) {
        const CellLines across =
            cell_lines_along(axis, in_rows_of(wall_cells, axis, mesh), rule, wall_cells);
        for (std::size_t i = 0; i < walls.size(); ++i) {
            lines.windings[walls[i]] |= across.windings[i];
        }
    }

    out.share.resize(out.cells.size());
    for (std::size_t c = 0; c < out.cells.size(); ++c) {
        const double exact = by_columns(volumes, c);
        const std::uint8_t w = lines.windings[c];
        const bool sure = w == 0 || w == WindingBit::plus_one || w == WindingBit::minus_one;
        out.share[c] =
            sure && exact < 1 + 1e-6 ? snapped(exact) : std::popcount(lines.inside[c]) / 64.0;
    }
    return out;
}

}  // namespace geometry
