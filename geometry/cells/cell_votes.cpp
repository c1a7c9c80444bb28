#include "geometry/cells/cell_votes.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace geometry {
namespace {

// Cells in the order of an axis's rows.
struct Rows {
    std::vector<std::uint32_t> order;  // of cells, by (w, v, u)
    std::vector<std::size_t> layers;   // into order, where the cells' w changes, and the end
};

Rows rows_of(std::span<const Vec3i> cells, const Axes& axes)
{
    Rows out;
    out.order.resize(cells.size());
    for (std::uint32_t i = 0; i < out.order.size(); ++i) out.order[i] = i;
    const auto key = [&](std::uint32_t i) {
        return std::tuple(cells[i][axes.w], cells[i][axes.v], cells[i][axes.u]);
    };
    if (axes.u != 0) {
        std::sort(out.order.begin(), out.order.end(),
                  [&](auto a, auto b) { return key(a) < key(b); });
    }
    for (std::size_t i = 0; i < out.order.size(); ++i) {
        if (i == 0 || cells[out.order[i]][axes.w] != cells[out.order[i - 1]][axes.w]) {
            out.layers.push_back(i);
        }
    }
    out.layers.push_back(out.order.size());
    return out;
}

// What one axis's rays add.
struct AxisVote {
    Inside rule;
    Axes axes;
    int per_cell;
    std::span<const Vec3i> cells;
    std::span<std::int8_t> votes;
    std::span<std::uint8_t> windings;  // or none
    Rows rows;
    std::size_t su, sv, sw;  // strides of `votes` along u, v, w
};

// Of the stretches of a line between crossings that are longer than rounding makes them; cells
// begin..end of the rows' order.
void note_windings(const AxisVote& vote, std::size_t begin, std::size_t end,
                   std::span<const Crossing> line)
{
    constexpr double least = 1e-3;  // cells
    const auto place = [&](std::size_t c) { return vote.cells[vote.rows.order[c]][vote.axes.u]; };
    int left = 0;
    std::size_t c = begin;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        left += line[i].sign;
        const double from = line[i].u, to = line[i + 1].u;
        if (to - from < least || left == 0) continue;
        while (c < end && place(c) + 1 <= from) ++c;
        for (std::size_t k = c; k < end && place(k) < to; ++k) {
            vote.windings[vote.rows.order[k]] |= winding_bit(left);
        }
    }
}

// The votes of one line, at offset `offset` in the points of cells begin..end of the rows' order.
void vote_along(const AxisVote& vote, std::size_t begin, std::size_t end,
                std::span<const Crossing> line, std::size_t offset)
{
    const auto s = static_cast<std::size_t>(vote.per_cell);
    int total = 0, left = 0;
    for (const Crossing& c : line) total += weight(vote.rule, c);
    if (!vote.windings.empty()) note_windings(vote, begin, end, line);
    std::size_t i = 0;
    for (std::size_t c = begin; c < end; ++c) {
        const std::uint32_t cell = vote.rows.order[c];
        std::int8_t* points = &vote.votes[cell * s * s * s + offset];
        for (std::size_t k = 0; k < s; ++k) {
            const double u =
                vote.cells[cell][vote.axes.u] + (static_cast<double>(k) + 0.5) / vote.per_cell;
            for (; i < line.size() && line[i].u <= u; ++i) left += weight(vote.rule, line[i]);
            points[k * vote.su] =
                static_cast<std::int8_t>(points[k * vote.su] + two_votes(vote.rule, left, total));
        }
    }
}

// All lines through one layer of cells.
void vote_in_layer(const AxisVote& vote, const Crossings& crossings, std::size_t layer)
{
    const auto s = static_cast<std::size_t>(vote.per_cell);
    const std::vector<std::uint32_t>& order = vote.rows.order;
    const std::size_t first = vote.rows.layers[layer], last = vote.rows.layers[layer + 1];
    const int w = vote.cells[order[first]][vote.axes.w];
    for (std::size_t kw = 0; kw < s; ++kw) {
        const auto lines = crossings.in_layer(w * vote.per_cell + static_cast<int>(kw));
        std::size_t at = 0;  // into lines, which come in the same order as the rows
        for (std::size_t begin = first, end; begin < last; begin = end) {
            const int v = vote.cells[order[begin]][vote.axes.v];
            for (end = begin; end < last && vote.cells[order[end]][vote.axes.v] == v;) ++end;
            for (std::size_t kv = 0; kv < s; ++kv) {
                const int row = v * vote.per_cell + static_cast<int>(kv);
                while (at < lines.size() && lines[at].v < row) ++at;
                std::size_t stop = at;
                while (stop < lines.size() && lines[stop].v == row) ++stop;
                vote_along(vote, begin, end, lines.subspan(at, stop - at),
                           kv * vote.sv + kw * vote.sw);
                at = stop;
            }
        }
    }
}

}  // namespace

int axes_needed(const LatticeMesh& mesh, Inside rule)
{
    return rule == Inside::winding && is_closed(mesh) ? 1 : 3;
}

void add_votes(const LatticeMesh& mesh, Inside rule, int axis, int per_cell,
               std::span<const Vec3i> cells, std::vector<std::int8_t>& votes,
               std::span<std::uint8_t> windings)
{
    const Axes axes(axis);
    const Crossings crossings = find_crossings(mesh, axes, per_cell);
    const auto s = static_cast<std::size_t>(per_cell);
    const std::array<std::size_t, 3> stride{1, s, s * s};
    const AxisVote vote{rule,
                        axes,
                        per_cell,
                        cells,
                        votes,
                        windings,
                        rows_of(cells, axes),
                        stride[static_cast<std::size_t>(axes.u)],
                        stride[static_cast<std::size_t>(axes.v)],
                        stride[static_cast<std::size_t>(axes.w)]};
    parallel_for(vote.rows.layers.size() - 1, 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t layer = first; layer < last; ++layer) {
            vote_in_layer(vote, crossings, layer);
        }
    });
}

}  // namespace geometry
