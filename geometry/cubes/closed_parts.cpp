#include "geometry/cubes/closed_parts.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cells/cell_votes.hpp"
#include "geometry/cells/sub_cells.hpp"
#include "geometry/mesh/first_in_place.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace geometry {
namespace {

// The triangles with one number for all vertices in one place.
std::vector<Triangle> welded(const LatticeMesh& mesh)
{
    const auto number = first_in_place(std::span<const Vec3>(mesh.positions));
    std::vector<Triangle> out = mesh.triangles;
    for (Triangle& t : out) {
        for (auto& v : t) v = number[v];
    }
    return out;
}

// Of each triangle, the first of those that it hangs together with by vertices; triangles of
// different `kind` do not. no_index where `used`.
std::vector<std::uint32_t> pieces_of(const std::vector<Triangle>& triangles,
                                     const std::vector<std::uint16_t>& kind,
                                     const std::vector<std::uint8_t>& used)
{
    struct Use {
        std::uint32_t vertex;
        std::uint16_t kind;
        std::uint32_t triangle;
        bool operator<(const Use& o) const
        {
            return std::tie(vertex, kind, triangle) < std::tie(o.vertex, o.kind, o.triangle);
        }
    };
    std::vector<Use> uses;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (used[t]) continue;
        for (const auto v : triangles[t]) uses.push_back({v, kind[t], t});
    }
    std::sort(uses.begin(), uses.end());
    UnionFind joined(triangles.size());
    for (std::size_t i = 1; i < uses.size(); ++i) {
        const Use &a = uses[i - 1], &b = uses[i];
        if (a.vertex == b.vertex && a.kind == b.kind) joined.join(a.triangle, b.triangle);
    }
    std::vector<std::uint32_t> piece = joined.roots();
    for (std::uint32_t t = 0; t < piece.size(); ++t) {
        if (used[t]) piece[t] = no_index;
    }
    return piece;
}

// Which pieces have a border: an edge that they run more often one way than the other.
std::vector<std::uint8_t> open_pieces(const std::vector<EdgeUse>& uses,
                                      const std::vector<std::uint32_t>& piece)
{
    std::vector<std::uint8_t> open(piece.size(), 0);
    std::vector<std::pair<std::uint32_t, int>> runs;  // of one edge: piece, which way
    for (std::size_t i = 0; i < uses.size();) {
        runs.clear();
        std::size_t end = i;
        for (; end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b; ++end) {
            const std::uint32_t p = piece[uses[end].triangle];
            if (p != no_index) runs.emplace_back(p, uses[end].forward ? 1 : -1);
        }
        i = end;
        std::sort(runs.begin(), runs.end());
        for (std::size_t k = 0; k < runs.size();) {
            int sum = 0;
            const std::uint32_t p = runs[k].first;
            for (; k < runs.size() && runs[k].first == p; ++k) sum += runs[k].second;
            if (sum != 0) open[p] = 1;
        }
    }
    return open;
}

// Adds the closed pieces of those that are not used yet, and marks their triangles.
void add_parts(const LatticeMesh& mesh, const std::vector<Triangle>& triangles,
               const std::vector<EdgeUse>& uses, const std::vector<std::uint16_t>& kind,
               bool one_matter, std::vector<std::uint8_t>& used, std::vector<ClosedPart>& parts)
{
    constexpr double least = 1e-6;  // cells: a sheet of two sides encloses nothing
    const auto piece = pieces_of(triangles, kind, used);
    const auto open = open_pieces(uses, piece);
    std::vector<std::uint32_t> at(triangles.size(), no_index);
    std::vector<ClosedPart> found;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (piece[t] == no_index || open[piece[t]]) continue;
        auto& k = at[piece[t]];
        if (k == no_index) {
            k = static_cast<std::uint32_t>(found.size());
            found.push_back({{}, one_matter, 0});
        }
        ClosedPart& part = found[k];
        part.triangles.push_back(t);
        // About a vertex of its own, so that far from the origin nothing is lost.
        const auto& [a, b, c] = triangles[t];
        const Vec3& o = mesh.positions[triangles[part.triangles[0]][0]];
        part.volume +=
            (mesh.positions[a] - o).dot((mesh.positions[b] - o).cross(mesh.positions[c] - o)) / 6;
    }
    for (ClosedPart& part : found) {
        part.volume = std::abs(part.volume);
        if (!(part.volume > least)) continue;
        for (const auto t : part.triangles) used[t] = 1;
        parts.push_back(std::move(part));
    }
}

LatticeMesh mesh_of(const LatticeMesh& mesh, const ClosedPart& part)
{
    LatticeMesh out;
    std::vector<std::uint32_t> vertices;
    for (const auto t : part.triangles) {
        for (const auto v : mesh.triangles[t]) vertices.push_back(v);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (const auto v : vertices) out.positions.push_back(mesh.positions[v]);
    for (const auto t : part.triangles) {
        Triangle triangle = mesh.triangles[t];
        for (auto& v : triangle) {
            v = static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), v) -
                                           vertices.begin());
        }
        out.triangles.push_back(triangle);
    }
    out.closed = true;
    return out;
}

// Points of cells, per_cube^3 each, and what is known of them. Cubes of one cell share its points.
struct Points {
    int per_cube = 1;
    std::vector<std::uint32_t> cube;    // sorted
    std::vector<std::size_t> place;     // of each cube: its cell
    std::vector<Vec3i> cell;            // each once
    std::vector<std::uint32_t> part;    // of each point: the last part that it lies in
    std::vector<std::int16_t> winding;  // of each point: the sum over parts, or their number

    std::size_t of_each() const
    {
        return static_cast<std::size_t>(per_cube) * static_cast<std::size_t>(per_cube) *
               static_cast<std::size_t>(per_cube);
    }
    void add(std::uint32_t c, const Vec3i& of)
    {
        if (cell.empty() || cell.back() != of) cell.push_back(of);
        cube.push_back(c);
        place.push_back(cell.size() - 1);
    }
};

void lie_in(const LatticeMesh& part, std::uint32_t number, Inside rule, Points& points)
{
    Vec3 lo = part.positions[0], hi = lo;
    for (const Vec3& p : part.positions) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
    const Vec3i first = cell_of(lo), last = cell_of(hi);
    const auto below = [](const Vec3i& c, int z) { return c.z() < z; };
    const auto begin = std::lower_bound(points.cell.begin(), points.cell.end(), first.z(), below);
    const auto end = std::lower_bound(begin, points.cell.end(), last.z() + 1, below);
    std::vector<std::size_t> near;
    std::vector<Vec3i> cells;
    for (auto it = begin; it != end; ++it) {
        if (((*it - first).array() < 0).any() || ((last - *it).array() < 0).any()) continue;
        near.push_back(static_cast<std::size_t>(it - points.cell.begin()));
        cells.push_back(*it);
    }
    if (near.empty()) return;
    const std::size_t n = points.of_each();
    std::vector<std::int8_t> votes(n * near.size(), 0);
    add_votes(part, Inside::winding, 0, points.per_cube, cells, votes);
    for (std::size_t i = 0; i < near.size(); ++i) {
        for (std::size_t k = 0; k < n; ++k) {
            const int vote = votes[n * i + k];
            if (vote == 0) continue;
            const std::size_t at = n * near[i] + k;
            const int turn = rule == Inside::parity || vote > 0 ? 1 : -1;
            // A hollow leaves what it takes away to the part that it is in, or that is in it.
            if (turn > 0 || points.part[at] == no_index) points.part[at] = number;
            points.winding[at] = static_cast<std::int16_t>(points.winding[at] + turn);
        }
    }
}

// Of a cube that is one piece of several in its cell, the points in its quarters: as many as
// points.
void add_shares(const Points& points, const Cubes& cubes, Inside rule,
                std::vector<PartShare>& shares)
{
    const std::size_t n = points.of_each();
    std::vector<std::uint32_t> own;
    for (std::size_t i = 0; i < points.cube.size(); ++i) {
        const SubCells held =
            cubes.part.empty() || n == 1 ? all_sub_cells : cubes.part[points.cube[i]];
        own.clear();
        for (std::size_t k = 0; k < n; ++k) {
            if ((held >> k & 1) == 0) continue;
            const std::size_t at = n * points.place[i] + k;
            const int w = points.winding[at];
            if (rule == Inside::parity ? w % 2 != 0 : w != 0) own.push_back(points.part[at]);
        }
        std::sort(own.begin(), own.end());
        for (std::size_t k = 0; k < own.size();) {
            const std::size_t begin = k;
            while (k < own.size() && own[k] == own[begin]) ++k;
            shares.push_back({points.cube[i], own[begin],
                              static_cast<double>(k - begin) / static_cast<double>(n)});
        }
    }
}

}  // namespace

std::vector<ClosedPart> find_closed_parts(const LatticeMesh& mesh, const FaceMatter& matter)
{
    const std::vector<Triangle> triangles = welded(mesh);
    const std::vector<EdgeUse> uses = edge_uses(triangles, mesh.positions.size());
    std::vector<std::uint16_t> kind(triangles.size());
    for (std::uint32_t t = 0; t < kind.size(); ++t) kind[t] = matter.of(mesh.source_of(t));
    std::vector<std::uint8_t> used(triangles.size(), 0);
    std::vector<ClosedPart> parts;
    add_parts(mesh, triangles, uses, kind, true, used, parts);
    std::fill(kind.begin(), kind.end(), std::uint16_t{0});
    add_parts(mesh, triangles, uses, kind, false, used, parts);
    std::stable_sort(parts.begin(), parts.end(),
                     [](const auto& a, const auto& b) { return a.volume > b.volume; });
    return parts;
}

std::vector<PartShare> part_shares(const LatticeMesh& mesh, std::span<const ClosedPart> parts,
                                   Inside rule, const Cubes& cubes,
                                   std::span<const std::uint8_t> cut)
{
    Points fine, coarse;
    fine.per_cube = across_cell;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const bool whole = cubes.part.empty() || cubes.part[c] == all_sub_cells;
        (cut[c] || !whole ? fine : coarse).add(c, cubes.cell[c]);
    }
    for (Points* points : {&fine, &coarse}) {
        points->part.assign(points->of_each() * points->cell.size(), no_index);
        points->winding.assign(points->part.size(), 0);
    }
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        const LatticeMesh part = mesh_of(mesh, parts[p]);
        lie_in(part, p, rule, fine);
        lie_in(part, p, rule, coarse);
    }
    std::vector<PartShare> shares;
    add_shares(fine, cubes, rule, shares);
    add_shares(coarse, cubes, rule, shares);
    std::sort(shares.begin(), shares.end(), [](const PartShare& a, const PartShare& b) {
        return std::tie(a.cube, a.part) < std::tie(b.cube, b.part);
    });
    return shares;
}

}  // namespace geometry
