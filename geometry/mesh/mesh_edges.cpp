#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>

namespace geometry {
namespace {

bool proper(const Triangle& t, std::size_t vertex_count)
{
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0] &&
           std::max({t[0], t[1], t[2]}) < vertex_count;
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
    for (std::uint32_t i = 0; i < triangles.size(); ++i) {
        const Triangle& t = triangles[i];
        if (!proper(t, vertex_count)) continue;
        for (std::uint8_t s = 0; s < 3; ++s) {
            const std::uint32_t from = t[s], to = t[(s + 1u) % 3];
            const auto [a, b] = std::minmax(from, to);
            uses[next[a]++] = {a, b, i, s, from < to};
        }
    }
    for (std::size_t v = 0; v < vertex_count; ++v) {
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

std::size_t disagreeing_edges(std::span<const Triangle> triangles, std::size_t vertex_count)
{
    const std::vector<EdgeUse> uses = edge_uses(triangles, vertex_count);
    std::size_t count = 0;
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
        count += end - i == 2 && uses[i].forward == uses[i + 1].forward;
    }
    return count;
}

}  // namespace geometry
