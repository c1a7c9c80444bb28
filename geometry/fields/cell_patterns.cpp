#include "geometry/fields/cell_patterns.hpp"

#include <algorithm>
#include <cstddef>

namespace geometry {
namespace {

using EdgeCorners = std::array<std::array<std::uint8_t, 2>, 12>;

constexpr std::uint8_t no_edge = 0xff;

EdgeCorners corners_of_edges()
{
    EdgeCorners corners{};
    for (int d = 0; d < 3; ++d) {
        for (int i = 0; i < 4; ++i) {
            const int lo = (i & 1) << (d + 1) % 3 | (i >> 1) << (d + 2) % 3;
            corners[static_cast<std::size_t>(4 * d + i)] = {static_cast<std::uint8_t>(lo),
                                                            static_cast<std::uint8_t>(lo | 1 << d)};
        }
    }
    return corners;
}

// Corners of a face, counter-clockwise seen from outside the cell.
std::array<int, 4> ring(std::uint8_t face)
{
    const int d = face / 2, s = face % 2;
    const int u = 1 << (d + 1) % 3, v = 1 << (d + 2) % 3, base = s << d;
    return s ? std::array{base, base | u, base | u | v, base | v}
             : std::array{base, base | v, base | u | v, base | u};
}

std::uint8_t edge_between(const EdgeCorners& edges, int a, int b)
{
    for (std::uint8_t e = 0; e < 12; ++e) {
        if (edges[e][0] == std::min(a, b) && edges[e][1] == std::max(a, b)) return e;
    }
    return no_edge;
}

int crossings(unsigned pattern, std::uint8_t face)
{
    const auto corners = ring(face);
    int count = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        count += (pattern >> corners[i] & 1) != (pattern >> corners[(i + 1) % 4] & 1);
    }
    return count;
}

bool one_sheet(const EdgeCorners& edges, const CellSheets& traced, std::uint8_t face)
{
    const auto corners = ring(face);
    const auto sheet = [&](std::size_t i) {
        return traced.of_edge[edge_between(edges, corners[i], corners[i + 1])];
    };
    return sheet(0) == sheet(1) && sheet(1) == sheet(2);
}

// Each face gives curves from a crossing where its ring leaves the inside to one where it enters
// it: to the last such before (cutting off the inside corners between them) or, on `other_way`, the
// next after. Chained from face to face they close into the sheets' borders.
CellSheets trace(const EdgeCorners& edges, unsigned pattern, std::uint8_t other_way)
{
    std::array<std::uint8_t, 12> next;
    next.fill(no_edge);
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
            next[edge_between(edges, corners[i % 4], corners[(i + 1) % 4])] =
                edge_between(edges, corners[j % 4], corners[(j + 1) % 4]);
        }
    }
    CellSheets traced;
    traced.of_edge.fill(no_sheet);
    for (std::uint8_t e = 0; e < 12; ++e) {
        if (next[e] == no_edge || traced.of_edge[e] != no_sheet) continue;
        for (std::uint8_t x = e; traced.of_edge[x] == no_sheet; x = next[x]) {
            traced.of_edge[x] = traced.count;
        }
        ++traced.count;
    }
    return traced;
}

CellPatterns make_patterns()
{
    CellPatterns table;
    const EdgeCorners& edges = table.edge_corners = corners_of_edges();
    for (unsigned pattern = 0; pattern < 256; ++pattern) {
        auto& [usual, other] = table.sheets[pattern];
        std::uint8_t& troublesome = table.troublesome[pattern] = no_face;
        usual = trace(edges, pattern, no_face);
        for (std::uint8_t face = 0; face < 6; ++face) {
            if (crossings(pattern, face) == 4 && one_sheet(edges, usual, face)) troublesome = face;
        }
        other = trace(edges, pattern, troublesome);
    }
    return table;
}

}  // namespace

const CellPatterns& cell_patterns()
{
    static const CellPatterns table = make_patterns();
    return table;
}

}  // namespace geometry
