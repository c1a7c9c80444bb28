#include "geometry/mesh/mesh_edges.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"

#include <algorithm>

namespace geometry {
namespace {

bool proper(const Triangle& t, std::size_t vertex_count)
{
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0] &&
           std::max({t[0], t[1], t[2]}) < vertex_count;
}

// Sides are numbered 3 triangle + side.
std::uint32_t number_of(const EdgeUse& use)
{
    return 3 * use.triangle + use.side;
}

std::uint32_t next_side(std::uint32_t side)
{
    return side % 3 == 2 ? side - 2 : side + 1;
}

// What lies across each side of each triangle: the side of another triangle that runs it back. On a
// border nothing does.
struct Sides {
    std::vector<std::uint32_t> across;  // 3 F, no_index where there is none
    std::vector<std::uint8_t> border;   // 3 F
};

// Of the uses of one edge: the first that runs it forward with the first that runs it back, and so
// on.
void pair_up(std::span<const EdgeUse> uses, Sides& sides)
{
    const auto skip_to = [&](std::size_t i, bool forward) {
        while (i < uses.size() && uses[i].forward != forward) ++i;
        return i;
    };
    for (const EdgeUse& use : uses) sides.border[number_of(use)] = 1;
    std::size_t f = skip_to(0, true), b = skip_to(0, false);
    while (f < uses.size() && b < uses.size()) {
        const std::uint32_t one = number_of(uses[f]), other = number_of(uses[b]);
        sides.across[one] = other, sides.across[other] = one;
        sides.border[one] = sides.border[other] = 0;
        f = skip_to(f + 1, true), b = skip_to(b + 1, false);
    }
}

Sides find_sides(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    Sides sides{std::vector<std::uint32_t>(3 * triangles.size(), no_index),
                std::vector<std::uint8_t>(3 * triangles.size(), 0)};
    const std::vector<EdgeUse> uses = edge_uses(triangles, vertex_count);
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
        pair_up(std::span(uses).subspan(i, end - i), sides);
    }
    return sides;
}

}  // namespace

std::vector<EdgeUse> edge_uses(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    // Counting sort by a, then the few uses that share it by (b, triangle).
    std::vector<std::uint32_t> start(vertex_count + 1, 0);
    for (const Triangle& t : triangles) {
        if (!proper(t, vertex_count)) continue;
        for (std::size_t s = 0; s < 3; ++s) ++start[std::min(t[s], t[(s + 1) % 3]) + 1];
    }
    for (std::size_t v = 0; v < vertex_count; ++v) start[v + 1] += start[v];
    std::vector<EdgeUse> uses(start[vertex_count]);
    std::vector<std::uint32_t> next(start.begin(), start.end() - 1);
    StopCheck check;
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        check();
        const Triangle& t = triangles[i];
        if (!proper(t, vertex_count)) continue;
        for (std::uint8_t s = 0; s < 3; ++s) {
            const std::uint32_t from = t[s], to = t[(s + 1u) % 3];
            const auto [a, b] = std::minmax(from, to);
            uses[next[a]++] = {a, b, i, s, from < to};
        }
    }
    for (std::size_t v = 0; v < vertex_count; ++v) {
        check();
        std::sort(uses.begin() + start[v], uses.begin() + start[v + 1],
                  [](const EdgeUse& p, const EdgeUse& q) {
                      return p.b != q.b ? p.b < q.b : p.triangle < q.triangle;
                  });
    }
    return uses;
}

bool is_closed(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    const std::vector<EdgeUse> uses = edge_uses(triangles, vertex_count);
    for (std::size_t i = 0; i < uses.size();) {
        int balance = 0;
        const std::uint32_t a = uses[i].a, b = uses[i].b;
        for (; i < uses.size() && uses[i].a == a && uses[i].b == b; ++i) {
            balance += uses[i].forward ? 1 : -1;
        }
        if (balance != 0) return false;
    }
    return true;
}

std::vector<std::vector<std::uint32_t>> border_loops(std::span<const Triangle> triangles,
                                                     std::size_t vertex_count)
{
    Sides sides = find_sides(triangles, vertex_count);
    std::vector<std::vector<std::uint32_t>> loops;
    for (std::uint32_t first = 0; first < sides.border.size(); ++first) {
        if (sides.border[first] == 0) continue;
        std::vector<std::uint32_t>& loop = loops.emplace_back();
        for (std::uint32_t at = first; sides.border[at] != 0;) {
            sides.border[at] = 0;
            loop.push_back(triangles[at / 3][at % 3]);
            // Round the vertex where this side ends, to the side that leaves it along the border.
            at = next_side(at);
            while (sides.across[at] != no_index) at = next_side(sides.across[at]);
        }
    }
    return loops;
}

// How many edges `counts` is true of, by their uses.
template <class Counts>
static std::size_t edges_where(std::span<const Triangle> triangles, std::size_t vertex_count,
                               const Counts& counts)
{
    const std::vector<EdgeUse> uses = edge_uses(triangles, vertex_count);
    std::size_t count = 0;
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
        count += counts(std::span(uses).subspan(i, end - i)) ? 1 : 0;
    }
    return count;
}

std::size_t crowded_edges(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    return edges_where(triangles, vertex_count, [](const auto& uses) { return uses.size() > 2; });
}

std::size_t disagreeing_edges(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    return edges_where(triangles, vertex_count, [](const auto& uses) {
        return uses.size() == 2 && uses[0].forward == uses[1].forward;
    });
}

}  // namespace geometry
