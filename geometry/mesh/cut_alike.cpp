#include "geometry/mesh/cut_alike.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

namespace geometry {
namespace {

// A random number for each edge. It counts as negative where the edge is run downwards.
std::uint64_t number_of_edge(std::uint32_t from, std::uint32_t to)
{
    if (from == to) return 0;
    const auto [low, high] = std::minmax(from, to);
    std::uint64_t n = (std::uint64_t{low} << 32 | high) + 0x9e3779b97f4a7c15u;
    n = (n ^ n >> 30) * 0xbf58476d1ce4e5b9u;
    n = (n ^ n >> 27) * 0x94d049bb133111ebu;
    n ^= n >> 31;
    return from < to ? n : 0 - n;
}

// A polygon by its border: the sum of its triangles' edges, of which inner ones cancel. Polygons on
// one border have one sum, or its negative where they are wound against each other.
struct Bordered {
    std::uint64_t sum = 0;  // the smaller of the two
    std::uint32_t begin = 0, end = 0;
    bool forward = true;

    bool operator<(const Bordered& o) const
    {
        return std::tie(sum, begin) < std::tie(o.sum, o.begin);
    }
};

Bordered bordered(std::span<const Triangle> triangles, std::size_t begin, std::size_t end)
{
    std::uint64_t sum = 0;
    for (std::size_t t = begin; t < end; ++t) {
        const auto& [a, b, c] = triangles[t];
        sum += number_of_edge(a, b) + number_of_edge(b, c) + number_of_edge(c, a);
    }
    return {std::min(sum, 0 - sum), static_cast<std::uint32_t>(begin),
            static_cast<std::uint32_t>(end), sum <= 0 - sum};
}

// Whether two polygons with one sum have one border: with the second turned against the first, each
// edge is run as often up as down.
bool is_same_border(std::span<const Triangle> triangles, const Bordered& a, const Bordered& b)
{
    std::vector<std::array<std::uint32_t, 2>> up, down;
    const auto add = [&](const Bordered& of, bool turned) {
        for (std::size_t t = of.begin; t < of.end; ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
                if (from == to) continue;
                const auto [low, high] = std::minmax(from, to);
                ((from < to) != turned ? up : down).push_back({low, high});
            }
        }
    };
    add(a, !a.forward);
    add(b, b.forward);
    std::sort(up.begin(), up.end());
    std::sort(down.begin(), down.end());
    return up == down;
}

Triangle turned_over(const Triangle& t)
{
    return {t[0], t[2], t[1]};
}

// Whether two polygons on one border enclose a solid, as a cushion of two faces does. What is less
// than a hundredth of their area ^ 1.5 is between two cuts of a face that is not flat.
bool encloses(std::span<const Triangle> triangles, std::span<const Vec3f> positions,
              const Bordered& a, const Bordered& b)
{
    const Vec3 base = positions[triangles[a.begin][0]].cast<double>();
    double volume = 0, area = 0;
    const auto add = [&](const Bordered& of, double sign) {
        for (std::size_t t = of.begin; t < of.end; ++t) {
            const auto& [i, j, k] = triangles[t];
            const Vec3 p = positions[i].cast<double>() - base,
                       q = positions[j].cast<double>() - base,
                       r = positions[k].cast<double>() - base;
            volume += sign * p.dot(q.cross(r)) / 6;
            area += (q - p).cross(r - p).norm() / 4;  // of the mean of both
        }
    };
    add(a, a.forward ? 1 : -1);
    add(b, b.forward ? -1 : 1);
    return std::abs(volume) > 0.01 * std::pow(area, 1.5);
}

// Of polygons of several triangles. Returns the others, ascending, and beside these the triangles
// of quads that no polygon has the border of: two of the others may.
std::vector<std::uint32_t> cut_polygons_alike(std::span<Triangle> triangles,
                                              std::span<const std::uint32_t> polygon,
                                              std::span<const Vec3f> positions)
{
    std::vector<Bordered> all;
    std::vector<std::uint32_t> single;
    const bool known = polygon.size() == triangles.size();
    for (std::size_t begin = 0, end = 0; begin < triangles.size(); begin = end) {
        end = begin + 1;
        while (known && end < polygon.size() && polygon[end] == polygon[begin]) ++end;
        if (end == begin + 1) {
            single.push_back(static_cast<std::uint32_t>(begin));
        } else {
            all.push_back(bordered(triangles, begin, end));
        }
    }
    std::sort(all.begin(), all.end());
    std::vector<std::uint8_t> matched(all.size(), 0);
    StopCheck check;
    for (std::size_t i = 0, first = 0; i < all.size(); ++i) {
        check();
        if (all[i].sum != all[first].sum) first = i;
        const Bordered &to = all[first], &from = all[i];
        const bool differs = i != first && from.end - from.begin == to.end - to.begin;
        if (!differs || !is_same_border(triangles, to, from)) continue;
        if (encloses(triangles, positions, to, from)) continue;
        matched[first] = matched[i] = 1;
        for (std::uint32_t k = 0; k < to.end - to.begin; ++k) {
            const Triangle& t = triangles[to.begin + k];
            triangles[from.begin + k] = to.forward == from.forward ? t : turned_over(t);
        }
    }
    if (single.empty()) return single;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (matched[i] != 0 || all[i].end - all[i].begin != 2) continue;
        single.insert(single.end(), {all[i].begin, all[i].begin + 1});
    }
    std::sort(single.begin(), single.end());
    return single;
}

// Two triangles that make a flat quad.
struct Quad {
    std::array<std::uint32_t, 4> places;          // ascending
    std::array<std::uint32_t, 2> triangles;       // ascending
    std::array<std::uint32_t, 2> other_diagonal;  // places, ascending: not the edge of both

    bool operator<(const Quad& o) const
    {
        return std::tie(places, triangles) < std::tie(o.places, o.triangles);
    }
    bool is_cut_otherwise(const Quad& o) const
    {
        const auto &p = other_diagonal, &q = o.other_diagonal;
        std::array<std::uint32_t, 4> ends{p[0], p[1], q[0], q[1]};
        std::sort(ends.begin(), ends.end());
        return places == o.places && ends == places;
    }
};

class QuadFinder {
public:
    QuadFinder(std::span<const Triangle> triangles, std::span<const Vec3f> positions)
        : triangles_(triangles), positions_(positions)
    {}

    // Along each edge, of triangles that run it in opposite directions and do not fold back. Only
    // those that may be cut otherwise too, as their other diagonal is an edge.
    std::vector<Quad> find(std::span<const std::uint32_t> some) const
    {
        constexpr std::size_t crowded = 64;  // triangles at an edge: no surface
        std::vector<Triangle> own;
        for (const auto t : some) own.push_back(triangles_[t]);
        const std::vector<EdgeUse> uses = edge_uses(own, positions_.size());
        const auto is_edge = [&](const std::array<std::uint32_t, 2>& ends) {
            const auto found = std::lower_bound(
                uses.begin(), uses.end(), ends, [](const EdgeUse& use, const auto& e) {
                    return std::tie(use.a, use.b) < std::tie(e[0], e[1]);
                });
            return found != uses.end() && found->a == ends[0] && found->b == ends[1];
        };
        std::vector<Quad> out;
        StopCheck check;
        for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
            check();
            while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
            if (end - i > crowded) continue;
            for (std::size_t p = i; p < end; ++p) {
                for (std::size_t q = p + 1; q < end; ++q) {
                    if (uses[p].forward == uses[q].forward) continue;
                    const auto quad = quad_of(uses[p], uses[q], some);
                    if (quad && is_edge(quad->other_diagonal)) out.push_back(*quad);
                }
            }
        }
        std::sort(out.begin(), out.end());
        return out;
    }

    Vec3 area_of(std::uint32_t triangle) const
    {
        const auto& [a, b, c] = triangles_[triangle];
        return (at(b) - at(a)).cross(at(c) - at(a)) / 2;
    }

private:
    Vec3 at(std::uint32_t place) const { return positions_[place].cast<double>(); }

    std::optional<Quad> quad_of(const EdgeUse& p, const EdgeUse& q,
                                std::span<const std::uint32_t> some) const
    {
        constexpr double flat = 1e-4;  // of the edge, a corner off the plane
        const std::array<std::uint32_t, 2> t{some[p.triangle], some[q.triangle]};
        const std::uint32_t near = triangles_[t[0]][(p.side + 2u) % 3],
                            far = triangles_[t[1]][(q.side + 2u) % 3];
        const Vec3 normal = area_of(t[0]), other = area_of(t[1]);
        const double off = normal.dot(at(far) - at(p.a));
        if (!(normal.dot(other) > 0) ||
            std::abs(off) > flat * normal.norm() * (at(p.b) - at(p.a)).norm()) {
            return std::nullopt;
        }
        Quad quad{{p.a, p.b, near, far}, t, {std::min(near, far), std::max(near, far)}};
        std::sort(quad.places.begin(), quad.places.end());
        std::sort(quad.triangles.begin(), quad.triangles.end());
        return quad;
    }

    std::span<const Triangle> triangles_;
    std::span<const Vec3f> positions_;
};

// Each triangle is cut as one quad's at most.
void cut_quads_alike(std::span<Triangle> triangles, std::span<const std::uint32_t> some,
                     std::span<const Vec3f> positions)
{
    const QuadFinder finder(triangles, positions);
    const std::vector<Quad> quads = finder.find(some);
    std::vector<std::uint8_t> cut(triangles.size(), 0);
    const auto is_cut = [&](const Quad& q) { return cut[q.triangles[0]] || cut[q.triangles[1]]; };
    bool usable = false;
    for (std::size_t i = 0, first = 0; i < quads.size(); ++i) {
        if (!usable || quads[i].places != quads[first].places) {
            first = i;
            usable = !is_cut(quads[i]);
        }
        const Quad &to = quads[first], &from = quads[i];
        if (!usable || !to.is_cut_otherwise(from) || is_cut(from)) continue;
        const auto [a, b] = to.triangles;
        const auto [c, d] = from.triangles;
        const bool alike = finder.area_of(a).dot(finder.area_of(c)) > 0;
        const Triangle one = triangles[a], other = triangles[b];
        triangles[c] = alike ? one : turned_over(one);
        triangles[d] = alike ? other : turned_over(other);
        cut[a] = cut[b] = cut[c] = cut[d] = 1;
    }
}

}  // namespace

void cut_alike(std::span<Triangle> triangles, std::span<const std::uint32_t> polygon,
               std::span<const Vec3f> positions)
{
    const std::vector<std::uint32_t> single = cut_polygons_alike(triangles, polygon, positions);
    if (single.size() >= 4) cut_quads_alike(triangles, single, positions);
}

}  // namespace geometry
