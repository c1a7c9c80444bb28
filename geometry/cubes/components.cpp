// Union-find over runs of cubes instead of cubes, rows met in sorted order:
//   Rosenfeld, Pfaltz. Sequential operations in digital picture processing. JACM 13(4), 1966.

#include "geometry/cubes/components.hpp"

#include "geometry/base/union_find.hpp"
#include "geometry/cells/cell_set.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <numeric>
#include <span>

namespace geometry {
namespace {

// Joins runs of two rows that come within `slack` cells of overlapping along x.
void join_rows(const CellRuns& cells, std::size_t row, std::size_t other, int slack,
               UnionFind& sets)
{
    std::uint32_t i = cells.rows[row].first, j = cells.rows[other].first;
    const std::uint32_t i_end = cells.rows[row + 1].first, j_end = cells.rows[other + 1].first;
    while (i < i_end && j < j_end) {
        const CellRuns::Run &a = cells.runs[i], &b = cells.runs[j];
        if (a.x0 < b.x1 + slack && b.x0 < a.x1 + slack) sets.join(i, j);
        if (a.x1 < b.x1)
            ++i;
        else
            ++j;
    }
}

// Label of each cube as the number of the first cube joined to it. No cell holds two cubes.
std::vector<std::uint32_t> first_of_set_by_runs(const Cubes& cubes, Connectivity connectivity)
{
    const CellRuns cells = runs_of(cubes.cell);
    const std::size_t rows = cells.rows.size() - 1;
    UnionFind sets(cells.runs.size());
    const int face = connectivity == Connectivity::face ? 0 : 1;
    const int edge = connectivity == Connectivity::corner ? 1 : 0;
    struct Earlier {
        int dy, dz, slack;
        std::size_t at;
    };
    std::vector<Earlier> neighbours{{-1, 0, face, 0}, {0, -1, face, 0}};
    if (connectivity != Connectivity::face) {
        neighbours.insert(neighbours.end(), {{-1, -1, edge, 0}, {1, -1, edge, 0}});
    }
    for (std::size_t row = 0; row < rows; ++row) {
        for (Earlier& n : neighbours) {
            const std::pair wanted(cells.rows[row].z + n.dz, cells.rows[row].y + n.dy);
            const auto at = [&] { return std::pair(cells.rows[n.at].z, cells.rows[n.at].y); };
            while (n.at < row && at() < wanted) ++n.at;
            if (n.at < row && at() == wanted) join_rows(cells, row, n.at, n.slack, sets);
        }
    }
    std::vector<std::uint32_t> first(cubes.count());
    for (std::uint32_t r = 0; r < cells.runs.size(); ++r) {
        const CellRuns::Run& run = cells.runs[r];
        const std::uint32_t label = cells.runs[sets.root(r)].first;
        std::fill_n(first.begin() + run.first, run.x1 - run.x0, label);
    }
    return first;
}

std::span<const std::uint32_t> corners_of(const Cubes& cubes, std::uint32_t c)
{
    const auto& corners = cubes.corners[c];
    return std::span(corners).first(is_triangle(corners) ? 3 : 8);
}

// How many corners two cells share where they are joined.
int needed_for(Connectivity connectivity, bool triangle)
{
    if (connectivity == Connectivity::corner) return 1;
    return connectivity == Connectivity::edge || triangle ? 2 : 4;
}

// The same by shared corners, for cubes of which several lie in one cell, and the triangles of a
// sheet, whose corners come first.
std::vector<std::uint32_t> first_of_set_by_corners(const Cubes& cubes, Connectivity connectivity)
{
    std::vector<std::uint32_t> start(cubes.corner_count() + 1, 0);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (const std::uint32_t k : corners_of(cubes, c)) ++start[k + 1];
    }
    for (std::size_t k = 0; k + 1 < start.size(); ++k) start[k + 1] += start[k];
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1), around(start.back());
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (const std::uint32_t k : corners_of(cubes, c)) around[next[k]++] = c;
    }
    UnionFind sets(cubes.count());
    std::vector<std::uint32_t> met;
    std::vector<int> shared(cubes.count(), 0);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const int needed = needed_for(connectivity, is_triangle(cubes.corners[c]));
        met.clear();
        for (const std::uint32_t k : corners_of(cubes, c)) {
            if (needed == 1) {
                sets.join(c, around[start[k]]);
                continue;
            }
            for (std::uint32_t i = start[k]; i < start[k + 1] && around[i] < c; ++i) {
                if (shared[around[i]]++ == 0) met.push_back(around[i]);
            }
        }
        for (const std::uint32_t other : met) {
            if (shared[other] >= needed) sets.join(c, other);
            shared[other] = 0;
        }
    }
    std::vector<std::uint32_t> first(cubes.count());
    for (std::uint32_t c = 0; c < first.size(); ++c) first[c] = sets.root(c);
    return first;
}

}  // namespace

Components find_components(const Cubes& cubes, Connectivity connectivity, Largest largest)
{
    // Copies of a cell, or neighbours that are not glued, show as two corners in one place.
    const bool glued =
        !cubes.is_sheet() &&
        std::adjacent_find(cubes.corner.begin(), cubes.corner.end()) == cubes.corner.end();
    std::vector<std::uint32_t> label = glued ? first_of_set_by_runs(cubes, connectivity)
                                             : first_of_set_by_corners(cubes, connectivity);
    // first cube of each component -> its number in order of appearance, then by size
    std::vector<std::uint32_t> firsts;
    for (std::uint32_t c = 0; c < label.size(); ++c) {
        if (label[c] == c) firsts.push_back(c);
    }
    std::vector<std::uint32_t> number(cubes.count());
    for (std::uint32_t i = 0; i < firsts.size(); ++i) number[firsts[i]] = i;
    std::vector<std::size_t> count(firsts.size(), 0);
    std::vector<double> mass(firsts.size(), 0.0);
    for (std::size_t c = 0; c < label.size(); ++c) {
        label[c] = number[label[c]];
        ++count[label[c]];
        mass[label[c]] += cubes.mass.empty() ? 0.0 : cubes.mass[c];
    }
    std::vector<std::uint32_t> order(firsts.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return largest == Largest::by_mass ? mass[a] > mass[b] : count[a] > count[b];
    });
    Components out;
    for (std::uint32_t rank = 0; rank < order.size(); ++rank) {
        out.cubes.push_back(count[order[rank]]);
        out.mass.push_back(mass[order[rank]]);
    }
    for (std::uint32_t rank = 0; rank < order.size(); ++rank) number[order[rank]] = rank;
    if (firsts.size() > 1) {
        for (std::uint32_t& l : label) l = number[l];
    }
    out.label = std::move(label);
    return out;
}

NearestCube nearest_cube(const Cubes& cubes, const Vec3& p)
{
    if (cubes.is_sheet()) {
        const auto hit = TriangleBvh(sheet_mesh(cubes)).closest(p);
        return hit ? NearestCube{hit.triangle, hit.distance} : NearestCube{};
    }
    const Vec3 at = (p - cubes.origin) / cubes.size;
    NearestCube best;
    double best_sq = std::numeric_limits<double>::infinity();
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const Vec3 lo = cubes.cell[c].cast<double>();
        double d_sq =
            (lo - at).cwiseMax(at - lo - Vec3::Ones()).cwiseMax(Vec3::Zero()).squaredNorm();
        if (d_sq > best_sq) continue;
        if (!cubes.part.empty()) d_sq = quarters_distance_sq(cubes.part[c], at - lo);
        const bool fuller = !cubes.part.empty() && cubes.fill[c] > cubes.fill[best.cube];
        if (d_sq < best_sq || (d_sq == best_sq && fuller)) best_sq = d_sq, best.cube = c;
    }
    best.distance = std::sqrt(best_sq) * cubes.size;
    return best;
}

}  // namespace geometry
