// Rays of one axis, all at once: each triangle is scan-converted in the plane across the axis, and
// leaves a signed crossing in every row whose line passes through it. The ends of a scan line are
// computed from an edge's two vertices alone, in an order of their own, so the triangles on both
// sides of an edge agree to the last bit on which rows are whose: on a closed mesh the crossings
// of every row balance exactly, whatever rounding does.
//
//   w_left(u) = sum of signs at u' < u,    w_right(u) = -sum of signs at u' > u

#include "geometry/solid_cells.hpp"

#include "geometry/mesh_edges.hpp"
#include "geometry/parallel.hpp"
#include "geometry/surface_cells.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

constexpr int fine = 4;  // points along a cell's edge for its share
constexpr std::size_t fine_points = fine * fine * fine;

// Rays run along u through rows (v, w): x, y, z in cyclic order, so that signs agree.
struct Axes {
    int u, v, w;
    explicit Axes(int axis) : u(axis), v((axis + 1) % 3), w((axis + 2) % 3) {}
};

struct Crossing {
    double u;  // in cells
    int v;     // row
    int sign;
};

// Crossings of the lines v = (row + 1/2) / per_cell, w likewise; layer by layer of equal w row,
// each sorted by (v, u).
struct Crossings {
    int first_layer = 0;
    std::vector<std::size_t> layer;  // starts, and the end of the last
    std::vector<Crossing> all;

    std::span<const Crossing> in_layer(int w) const
    {
        const int i = w - first_layer;
        if (i < 0 || i + 1 >= static_cast<int>(layer.size())) return {};
        const auto k = static_cast<std::size_t>(i);
        return std::span(all).subspan(layer[k], layer[k + 1] - layer[k]);
    }
};

// First whole number whose centre (i + 1/2) is not below x.
int first_centre(double x)
{
    return static_cast<int>(std::ceil(x - 0.5));
}

// Where edge ab passes height w: its v and u there.
struct OnEdge {
    double v, u;
};
OnEdge at_height(const Vec3& a, const Vec3& b, double w)
{
    const Vec3 &lo = a.z() <= b.z() ? a : b, &hi = a.z() <= b.z() ? b : a;
    const double t = (w - lo.z()) / (hi.z() - lo.z());
    return {lo.y() + t * (hi.y() - lo.y()), lo.x() + t * (hi.x() - lo.x())};
}

// Calls emit(w row, crossing) for each row that the triangle crosses. Corners as (u, v, w).
template <class Emit> void scan(const Vec3& a, const Vec3& b, const Vec3& c, const Emit& emit)
{
    const int w0 = first_centre(std::min({a.z(), b.z(), c.z()}));
    const int w1 = first_centre(std::max({a.z(), b.z(), c.z()}));
    for (int w = w0; w < w1; ++w) {
        const double height = w + 0.5;
        const bool above_a = a.z() > height, above_b = b.z() > height, above_c = c.z() > height;
        OnEdge up{}, down{};
        if (above_a != above_b) (above_b ? up : down) = at_height(a, b, height);
        if (above_b != above_c) (above_c ? up : down) = at_height(b, c, height);
        if (above_c != above_a) (above_a ? up : down) = at_height(c, a, height);
        const int sign = up.v < down.v ? 1 : -1;
        const OnEdge &from = sign > 0 ? up : down, &to = sign > 0 ? down : up;
        const int v0 = first_centre(from.v), v1 = first_centre(to.v);
        const double slope = v0 < v1 ? (to.u - from.u) / (to.v - from.v) : 0;
        for (int v = v0; v < v1; ++v) {
            emit(w, Crossing{from.u + (v + 0.5 - from.v) * slope, v, sign});
        }
    }
}

Crossings find_crossings(const LatticeMesh& mesh, const Axes& axes, int per_cell)
{
    const double scale = per_cell;
    std::vector<Vec3> turned(mesh.positions.size());
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (std::size_t v = 0; v < turned.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        turned[v] = {p[axes.u], scale * p[axes.v], scale * p[axes.w]};
    }
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            lo = std::min(lo, turned[v].z());
            hi = std::max(hi, turned[v].z());
        }
    }
    Crossings out;
    if (!(lo <= hi)) return out;
    out.first_layer = first_centre(lo);
    const auto layers = static_cast<std::size_t>(std::max(0, first_centre(hi) - out.first_layer));
    out.layer.assign(layers + 1, 0);
    struct Placed {
        Crossing crossing;
        int layer;
    };
    std::vector<Placed> placed;
    for (const auto& [a, b, c] : mesh.triangles) {
        scan(turned[a], turned[b], turned[c], [&](int w, const Crossing& crossing) {
            placed.push_back({crossing, w - out.first_layer});
            ++out.layer[static_cast<std::size_t>(w - out.first_layer) + 1];
        });
    }
    for (std::size_t k = 0; k < layers; ++k) out.layer[k + 1] += out.layer[k];
    std::vector<std::size_t> next(out.layer.begin(), out.layer.end());
    out.all.resize(placed.size());
    for (const Placed& p : placed) out.all[next[static_cast<std::size_t>(p.layer)]++] = p.crossing;
    parallel_for(layers, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            std::sort(out.all.begin() + static_cast<std::ptrdiff_t>(out.layer[k]),
                      out.all.begin() + static_cast<std::ptrdiff_t>(out.layer[k + 1]),
                      [](const Crossing& p, const Crossing& q) {
                          return p.v != q.v ? p.v < q.v : p.u != q.u ? p.u < q.u : p.sign < q.sign;
                      });
        }
    });
    return out;
}

int sign_of(int x)
{
    return (x > 0) - (x < 0);
}

// What the two rays along a line vote at a point with `left` crossings (their sum for winding,
// their number for parity) on one side, of `total` on the line.
int two_votes(Inside rule, int left, int total)
{
    if (rule == Inside::parity) return (left & 1) + ((total - left) & 1);
    return sign_of(left) + sign_of(left - total);
}

int weight(Inside rule, const Crossing& c)
{
    return rule == Inside::parity ? 1 : c.sign;
}

// Calls emit(u0, u1, v, w) for every run of cells whose centres both rays of the axis hold inside.
template <class Emit> void inside_runs(const Crossings& crossings, Inside rule, const Emit& emit)
{
    for (std::size_t k = 0; k + 1 < crossings.layer.size(); ++k) {
        const int w = crossings.first_layer + static_cast<int>(k);
        const std::span<const Crossing> layer = crossings.in_layer(w);
        for (std::size_t begin = 0, end = 0; begin < layer.size(); begin = end) {
            int total = 0, left = 0;
            for (; end < layer.size() && layer[end].v == layer[begin].v; ++end) {
                total += weight(rule, layer[end]);
            }
            for (std::size_t i = begin; i + 1 < end; ++i) {
                left += weight(rule, layer[i]);
                if (std::abs(two_votes(rule, left, total)) < 2) continue;
                const int u0 = first_centre(layer[i].u), u1 = first_centre(layer[i + 1].u) - 1;
                if (u0 <= u1) emit(u0, u1, layer[i].v, w);
            }
        }
    }
}

std::uint8_t winding_bit(int winding)  // not 0
{
    return winding == 1    ? CellLines::plus_one
           : winding == -1 ? CellLines::minus_one
                           : CellLines::beyond;
}

// Adds one axis's votes at per_cell^3 points in each cell; votes[cell per_cell^3 + x + y per_cell +
// z per_cell^2]. `windings`, unless empty: notes those that the lines run through in each cell.
void vote(const LatticeMesh& mesh, Inside rule, int axis, int per_cell,
          std::span<const Vec3i> cells, std::vector<std::int8_t>& votes,
          std::span<std::uint8_t> windings = {})
{
    const Axes axes(axis);
    const Crossings crossings = find_crossings(mesh, axes, per_cell);
    const auto s = static_cast<std::size_t>(per_cell);
    const std::array<std::size_t, 3> stride{1, s, s * s};
    const std::size_t su = stride[static_cast<std::size_t>(axes.u)];
    const std::size_t sv = stride[static_cast<std::size_t>(axes.v)];
    const std::size_t sw = stride[static_cast<std::size_t>(axes.w)];

    // Cells in the order of this axis's rows.
    std::vector<std::uint32_t> order(cells.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto key = [&](std::uint32_t i) {
        return std::tuple(cells[i][axes.w], cells[i][axes.v], cells[i][axes.u]);
    };
    if (axis != 0) {
        std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
    }
    std::vector<std::size_t> layers;  // where the cells' w changes
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i == 0 || cells[order[i]][axes.w] != cells[order[i - 1]][axes.w]) layers.push_back(i);
    }
    layers.push_back(order.size());

    // Of the stretches between crossings that are longer than rounding makes them.
    const auto note_windings = [&](std::size_t begin, std::size_t end,
                                   std::span<const Crossing> line) {
        constexpr double least = 1e-3;  // cells
        int left = 0;
        std::size_t c = begin;
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
            left += line[i].sign;
            const double from = line[i].u, to = line[i + 1].u;
            if (to - from < least || left == 0) continue;
            while (c < end && cells[order[c]][axes.u] + 1 <= from) ++c;
            for (std::size_t k = c; k < end && cells[order[k]][axes.u] < to; ++k) {
                windings[order[k]] |= winding_bit(left);
            }
        }
    };
    const auto row_of_cells = [&](std::size_t begin, std::size_t end,
                                  std::span<const Crossing> line, std::size_t offset) {
        int total = 0, left = 0;
        for (const Crossing& c : line) total += weight(rule, c);
        if (!windings.empty()) note_windings(begin, end, line);
        std::size_t i = 0;
        for (std::size_t c = begin; c < end; ++c) {
            std::int8_t* points = &votes[order[c] * s * s * s + offset];
            for (std::size_t k = 0; k < s; ++k) {
                const double u =
                    cells[order[c]][axes.u] + (static_cast<double>(k) + 0.5) / per_cell;
                for (; i < line.size() && line[i].u <= u; ++i) left += weight(rule, line[i]);
                points[k * su] =
                    static_cast<std::int8_t>(points[k * su] + two_votes(rule, left, total));
            }
        }
    };
    parallel_for(layers.size() - 1, 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t layer = first; layer < last; ++layer) {
            const int w = cells[order[layers[layer]]][axes.w];
            for (std::size_t kw = 0; kw < s; ++kw) {
                const auto lines = crossings.in_layer(w * per_cell + static_cast<int>(kw));
                std::size_t at = 0;  // into lines, which come in the same order as the rows
                for (std::size_t begin = layers[layer], end; begin < layers[layer + 1];
                     begin = end) {
                    const int v = cells[order[begin]][axes.v];
                    for (end = begin; end < layers[layer + 1] && cells[order[end]][axes.v] == v;) {
                        ++end;
                    }
                    for (std::size_t kv = 0; kv < s; ++kv) {
                        const int row = v * per_cell + static_cast<int>(kv);
                        while (at < lines.size() && lines[at].v < row) ++at;
                        std::size_t stop = at;
                        while (stop < lines.size() && lines[stop].v == row) ++stop;
                        row_of_cells(begin, end, lines.subspan(at, stop - at), kv * sv + kw * sw);
                        at = stop;
                    }
                }
            }
        }
    });
}

// On a closed mesh the rays of one axis speak for all six.
int axes_needed(const LatticeMesh& mesh, Inside rule)
{
    return rule == Inside::winding && is_closed(mesh.triangles, mesh.positions.size()) ? 1 : 3;
}

// The cells whose centre is inside, one axis's word being enough.
void insert_inside(const LatticeMesh& mesh, Inside rule, CellSet& cells)
{
    inside_runs(find_crossings(mesh, Axes(0), 1), rule,
                [&](int u0, int u1, int v, int w) { cells.insert_run(u0, u1, v, w); });
}

// The same by vote. More than three of six votes need an axis both of whose rays agree: those
// cells are the candidates.
void insert_voted(const LatticeMesh& mesh, Inside rule, CellSet& cells)
{
    CellSet some;
    for (int axis = 0; axis < 3; ++axis) {
        const Axes axes(axis);
        inside_runs(find_crossings(mesh, axes, 1), rule, [&](int u0, int u1, int v, int w) {
            if (axis == 0) return some.insert_run(u0, u1, v, w);
            Vec3i cell;
            cell[axes.v] = v;
            cell[axes.w] = w;
            for (cell[axes.u] = u0; cell[axes.u] <= u1; ++cell[axes.u]) some.insert(cell);
        });
    }
    const std::vector<Vec3i> candidates = some.sorted();
    std::vector<std::int8_t> votes(candidates.size(), 0);
    for (int axis = 0; axis < 3; ++axis) vote(mesh, rule, axis, 1, candidates, votes);
    for (std::size_t c = 0; c < candidates.size(); ++c) {
        if (std::abs(votes[c]) > 3) cells.insert(candidates[c]);
    }
}

// Triangles that lie in a plane between cells, by the axis across it; lifted into the middle of
// the upper cells.
std::array<LatticeMesh, 3> between_cells(const LatticeMesh& mesh)
{
    std::array<LatticeMesh, 3> out;
    for (const auto& [a, b, c] : mesh.triangles) {
        const Vec3 &p = mesh.positions[a], &q = mesh.positions[b], &r = mesh.positions[c];
        for (int k = 0; k < 3; ++k) {
            if (p[k] != q[k] || q[k] != r[k] || p[k] != std::floor(p[k])) continue;
            LatticeMesh& flat = out[static_cast<std::size_t>(k)];
            const auto first = static_cast<std::uint32_t>(flat.positions.size());
            flat.positions.insert(flat.positions.end(), {p, q, r});
            for (std::size_t i = first; i < first + 3; ++i) flat.positions[i][k] += 0.5;
            flat.triangles.push_back({first, first + 1, first + 2});
            break;
        }
    }
    return out;
}

CellLines lines_along(int first_axis, int end_axis, const LatticeMesh& mesh, Inside rule,
                      std::span<const Vec3i> cells)
{
    std::vector<std::int8_t> votes(cells.size() * fine_points, 0);
    CellLines out;
    out.inside.assign(cells.size(), 0);
    out.windings.assign(cells.size(), 0);
    for (int axis = first_axis; axis < end_axis; ++axis) {
        vote(mesh, rule, axis, fine, cells, votes, out.windings);
    }
    for (std::size_t c = 0; c < cells.size(); ++c) {
        for (std::size_t i = 0; i < fine_points; ++i) {
            const bool in = std::abs(votes[c * fine_points + i]) > end_axis - first_axis;
            out.inside[c] |= std::uint64_t{in} << i;
        }
    }
    return out;
}

}  // namespace

CellSet solid_cells(const LatticeMesh& mesh, Inside rule, std::size_t limit)
{
    CellSet cells = surface_cells(mesh, Touch::interior, limit);
    if (axes_needed(mesh, rule) == 1) {
        insert_inside(mesh, rule, cells);
    } else {
        insert_voted(mesh, rule, cells);
    }
    std::vector<Vec3i> sheets;
    const std::array<LatticeMesh, 3> flat = between_cells(mesh);
    for (int k = 0; k < 3; ++k) {
        const LatticeMesh& faces = flat[static_cast<std::size_t>(k)];
        if (faces.triangles.empty()) continue;
        for (const Vec3i& c : surface_cells(faces, Touch::interior, limit).sorted()) {
            if (!cells.contains(c) && !cells.contains(c - Vec3i::Unit(k))) sheets.push_back(c);
        }
    }
    for (const Vec3i& c : sheets) cells.insert(c);
    return cells;
}

CellLines cell_lines(const LatticeMesh& mesh, Inside rule, std::span<const Vec3i> cells)
{
    return axes_needed(mesh, rule) == 1 ? lines_along(0, 1, mesh, rule, cells)
                                        : lines_along(0, 3, mesh, rule, cells);
}

CellLines cell_lines_along(int axis, const LatticeMesh& mesh, Inside rule,
                           std::span<const Vec3i> cells)
{
    return lines_along(axis, axis + 1, mesh, rule, cells);
}

}  // namespace geometry
