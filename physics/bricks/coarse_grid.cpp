#include "physics/bricks/coarse_grid.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "physics/state/loads.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace physics {
namespace {

using geometry::no_index;
using geometry::UnionFind;
using geometry::Vec3i;

int floor_ratio(int value, int ratio)
{
    return (value >= 0 ? value : value - ratio + 1) / ratio;
}

Vec3i coarse_place(const Vec3i& cell, int ratio)
{
    return {floor_ratio(cell.x(), ratio), floor_ratio(cell.y(), ratio),
            floor_ratio(cell.z(), ratio)};
}

// Turns keys round: of each key, the indices i with keys[i] = key, in order.
IndexLists lists_by_key(std::span<const std::uint32_t> keys, std::size_t count)
{
    IndexLists out;
    out.first.assign(count + 1, 0);
    for (const auto key : keys) {
        if (key != no_index) ++out.first[key + 1];
    }
    std::partial_sum(out.first.begin(), out.first.end(), out.first.begin());
    out.index.resize(out.first.back());
    std::vector<std::uint32_t> next(out.first.begin(), out.first.end() - 1);
    for (std::uint32_t i = 0; i < keys.size(); ++i) {
        if (keys[i] != no_index) out.index[next[keys[i]]++] = i;
    }
    return out;
}

IndexLists cells_at_corners(const GridView& fine)
{
    std::vector<std::uint32_t> keys;
    keys.reserve(8 * fine.cell.size());
    for (const Eight& eight : fine.corners) keys.insert(keys.end(), eight.begin(), eight.end());
    IndexLists out = lists_by_key(keys, fine.corner.size());
    for (auto& i : out.index) i /= 8;
    return out;
}

// The coarse cell of each cell. Fills out.cell.
std::vector<std::uint32_t> number_cells(const GridView& fine, const IndexLists& at_corner,
                                        CoarseGrid& out)
{
    const std::size_t n = fine.cell.size();
    std::vector<Vec3i> place(n);
    for (std::size_t c = 0; c < n; ++c) place[c] = coarse_place(fine.cell[c], out.ratio);
    UnionFind sets(n);
    for (std::size_t k = 0; k < fine.corner.size(); ++k) {
        const auto cells = at_corner.of(k);
        for (std::size_t i = 1; i < cells.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                if (place[cells[i]] != place[cells[j]]) continue;
                sets.join(cells[i], cells[j]);
                break;
            }
        }
    }
    const std::vector<std::uint32_t> root = sets.roots();
    std::vector<std::uint32_t> first;  // cells that are the first of their set
    for (std::uint32_t c = 0; c < n; ++c) {
        if (root[c] == c) first.push_back(c);
    }
    std::stable_sort(first.begin(), first.end(), [&](std::uint32_t a, std::uint32_t b) {
        const Vec3i &p = place[a], &q = place[b];
        return std::tuple(p.z(), p.y(), p.x()) < std::tuple(q.z(), q.y(), q.x());
    });
    std::vector<std::uint32_t> number(n, no_index);
    for (const auto c : first) {
        number[c] = static_cast<std::uint32_t>(out.cell.size());
        out.cell.push_back(place[c]);
    }
    for (std::size_t c = 0; c < n; ++c) number[c] = number[root[c]];
    return number;
}

// The nodes that move corner k are joined between all coarse cells that hold it.
void join_nodes(const GridView& fine, std::size_t k, std::span<const std::uint32_t> coarse,
                const CoarseGrid& grid, UnionFind& nodes)
{
    const auto each_node = [&](std::uint32_t c, const auto& visit) {
        const Vec3i at = place_in_cell(fine.corner[k], grid.cell[c], grid.ratio);
        for (unsigned a = 0; a < 8; ++a) {
            bool moves = true;
            for (int i = 0; i < 3; ++i) moves &= at[i] != (a >> i & 1 ? 0 : grid.ratio);
            if (moves) visit(Vec3i(a & 1, a >> 1 & 1, a >> 2 & 1), 8 * c + a);
        }
    };
    each_node(coarse[0], [&](const Vec3i& bits, std::uint32_t first) {
        const Vec3i node = grid.cell[coarse[0]] + bits;
        for (std::size_t i = 1; i < coarse.size(); ++i) {
            const Vec3i in_other = node - grid.cell[coarse[i]];
            nodes.join(first,
                       8 * coarse[i] + static_cast<std::uint32_t>(in_other.dot(Vec3i(1, 2, 4))));
        }
    });
}

void number_nodes(UnionFind& nodes, CoarseGrid& out)
{
    std::vector<std::uint32_t> number(8 * out.cell.size(), no_index), key(number.size());
    for (std::uint32_t i = 0; i < number.size(); ++i) {
        const auto root = nodes.root(i);
        if (root == i) {
            number[i] = static_cast<std::uint32_t>(out.node.size());
            const unsigned a = i % 8;
            out.node.emplace_back(out.cell[i / 8] + Vec3i(a & 1, a >> 1 & 1, a >> 2 & 1));
        }
        key[i] = number[root];
        out.nodes[i / 8][i % 8] = key[i];
    }
    out.shares = lists_by_key(key, out.node.size());
}

}  // namespace

CoarseGrid coarsen(const GridView& fine, int ratio, std::span<const std::uint8_t> held)
{
    CoarseGrid out;
    out.ratio = ratio;
    const IndexLists at_corner = cells_at_corners(fine);
    const std::vector<std::uint32_t> coarse_of = number_cells(fine, at_corner, out);
    out.cells = lists_by_key(coarse_of, out.cell.size());
    out.nodes.resize(out.cell.size());
    UnionFind nodes(8 * out.cell.size());
    std::vector<std::uint32_t> mover(fine.corner.size(), no_index), coarse;
    for (std::size_t k = 0; k < fine.corner.size(); ++k) {
        coarse.clear();
        for (const auto c : at_corner.of(k)) coarse.push_back(coarse_of[c]);
        if (coarse.empty()) continue;
        std::sort(coarse.begin(), coarse.end());
        coarse.erase(std::unique(coarse.begin(), coarse.end()), coarse.end());
        if (held.empty() || held[k] != all_axes) mover[k] = coarse.back();
        if (coarse.size() > 1) join_nodes(fine, k, coarse, out, nodes);
    }
    out.corners = lists_by_key(mover, out.cell.size());
    number_nodes(nodes, out);
    return out;
}

}  // namespace physics
