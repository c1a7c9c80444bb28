#include "geometry/cells/solid_cells.hpp"

#include "geometry/cells/cell_votes.hpp"
#include "geometry/cells/crossings.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace geometry {
namespace {

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

// The cells whose centre is inside, one axis's word being enough.
void insert_inside(const LatticeMesh& mesh, Inside rule, CellSet& cells)
{
    inside_runs(find_crossings(mesh, Axes(0), 1), rule,
                [&](int u0, int u1, int v, int w) { cells.insert_run(u0, u1, v, w); });
}

// The same by vote. More than three of six votes need an axis both of whose rays agree: those
// cells are the candidates. Where the rays of an axis are wrong they may be many times what is
// inside: more than twice `limit` of them are refused too.
void insert_voted(const LatticeMesh& mesh, Inside rule, std::size_t limit, CellSet& cells)
{
    CellSet some(std::max(limit, 2 * std::min(limit, std::size_t{1} << 56)));
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
    for (int axis = 0; axis < 3; ++axis) add_votes(mesh, rule, axis, 1, candidates, votes);
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

}  // namespace

CellSet solid_cells(const LatticeMesh& mesh, Inside rule, std::size_t limit)
{
    CellSet cells = surface_cells(mesh, CellShape::interior, limit);
    if (axes_needed(mesh, rule) == 1) {
        insert_inside(mesh, rule, cells);
    } else {
        insert_voted(mesh, rule, limit, cells);
    }
    std::vector<Vec3i> sheets;
    const std::array<LatticeMesh, 3> flat = between_cells(mesh);
    for (int k = 0; k < 3; ++k) {
        const LatticeMesh& faces = flat[static_cast<std::size_t>(k)];
        if (faces.triangles.empty()) continue;
        for (const Vec3i& c : surface_cells(faces, CellShape::interior, limit).sorted()) {
            if (!cells.contains(c) && !cells.contains(c - Vec3i::Unit(k))) sheets.push_back(c);
        }
    }
    for (const Vec3i& c : sheets) cells.insert(c);
    return cells;
}

}  // namespace geometry
