#include "geometry/mesh/solid_faces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/mesh/first_in_place.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/wound_out.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace geometry {
namespace {

// A triangle by its places, in ascending order, and whether it runs through them so.
struct Placed {
    std::array<std::uint32_t, 3> places;
    bool forward = true;
    std::uint16_t kind = 0;
    std::uint32_t triangle = 0;

    bool operator<(const Placed& o) const
    {
        return std::tie(places, forward, kind, triangle) <
               std::tie(o.places, o.forward, o.kind, o.triangle);
    }
    bool doubles(const Placed& o) const { return forward == o.forward && kind == o.kind; }
};

Placed placed(const Triangle& t, const std::vector<std::uint32_t>& place, std::uint16_t kind,
              std::uint32_t number)
{
    Placed out{{place[t[0]], place[t[1]], place[t[2]]}, true, kind, number};
    auto& p = out.places;
    const auto order = [&](std::size_t a, std::size_t b) {
        if (p[b] < p[a]) std::swap(p[a], p[b]), out.forward = !out.forward;
    };
    order(0, 1), order(1, 2), order(0, 1);
    return out;
}

// Behind the last of those in the same places as the one at i.
std::size_t end_of_places(const std::vector<Placed>& all, std::size_t i)
{
    std::size_t end = i + 1;
    while (end < all.size() && all[end].places == all[i].places) ++end;
    return end;
}

// Marks triangles that are the second of their places and way, and finds those that have another
// one against them.
void find_doubled(std::vector<Placed>& all, std::vector<std::uint8_t>& left_out,
                  std::vector<std::uint8_t>& two_sided)
{
    std::sort(all.begin(), all.end());
    for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
        end = end_of_places(all, i);
        const bool both = all[i].forward != all[end - 1].forward;
        for (std::size_t k = i; k < end; ++k) {
            if (k > i && all[k].doubles(all[k - 1])) left_out[all[k].triangle] = 1;
            if (both) two_sided[all[k].triangle] = 1;
        }
    }
}

// Pieces, by the first place of each vertex's: all of whose triangles have one against them, so
// that they are surfaces with two sides; `plain`: the others.
struct TwoSided {
    std::vector<std::uint32_t> piece;
    std::vector<std::uint8_t> plain;

    std::uint32_t of(const Placed& p) const { return piece[p.places[0]]; }
};

TwoSided find_two_sided(const std::vector<Placed>& all, std::size_t vertices,
                        const std::vector<std::uint8_t>& two_sided)
{
    UnionFind joined(vertices);
    for (const Placed& p : all) {
        joined.join(p.places[0], p.places[1]);
        joined.join(p.places[0], p.places[2]);
    }
    TwoSided out;
    out.piece = joined.roots();
    out.plain.assign(out.piece.size(), 0);
    for (const Placed& p : all) {
        if (two_sided[p.triangle] == 0) out.plain[out.of(p)] = 1;
    }
    return out;
}

// Of two-sided pieces, marks those as plain whose one side has a border: an edge of an odd number
// of triangles.
void keep_open_ones(const std::vector<Placed>& all, TwoSided& pieces)
{
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
        end = end_of_places(all, i);
        if (pieces.plain[pieces.of(all[i])] != 0) continue;
        const auto& [a, b, c] = all[i].places;  // ascending
        edges.insert(edges.end(), {{a, b}, {b, c}, {a, c}});
    }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
        end = i + 1;
        while (end < edges.size() && edges[end] == edges[i]) ++end;
        if ((end - i) % 2 != 0) pieces.plain[pieces.piece[edges[i][0]]] = 1;
    }
}

// Of two-sided pieces that close, the later of each two triangles is left out.
void leave_out_backs(const std::vector<Placed>& all, const TwoSided& pieces,
                     std::vector<std::uint8_t>& left_out)
{
    for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
        end = end_of_places(all, i);
        if (pieces.plain[pieces.of(all[i])] != 0) continue;
        std::uint32_t least = all[i].triangle;
        for (std::size_t k = i; k < end; ++k) least = std::min(least, all[k].triangle);
        for (std::size_t k = i; k < end; ++k) left_out[all[k].triangle] |= all[k].triangle != least;
    }
}

}  // namespace

SolidFaces solid_faces(const TriMesh& mesh, std::span<const std::uint16_t> kind)
{
    const std::vector<Triangle>& triangles = mesh.triangles();
    const std::size_t count = mesh.positions.size();
    const auto sound = [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
            return v < count && mesh.positions[v].allFinite();
        });
    };
    const auto place = first_in_place(std::span<const Vec3f>(mesh.positions));
    std::vector<Placed> all;
    std::vector<std::uint8_t> left_out(triangles.size(), 0), two_sided(triangles.size(), 0);
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (sound(triangles[t])) {
            all.push_back(
                placed(triangles[t], place, kind.empty() ? std::uint16_t{0} : kind[t], t));
        } else {
            left_out[t] = 1;
        }
    }
    const std::size_t unsound = triangles.size() - all.size();
    stop_if_asked();
    find_doubled(all, left_out, two_sided);
    stop_if_asked();
    TwoSided pieces = find_two_sided(all, count, two_sided);
    keep_open_ones(all, pieces);
    leave_out_backs(all, pieces, left_out);
    TriMesh once;
    once.positions = mesh.positions;
    auto topology = std::make_shared<MeshTopology>();
    SolidFaces out;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (left_out[t] != 0) continue;
        Triangle welded = triangles[t];
        for (auto& v : welded) v = place[v];
        topology->triangles.push_back(welded);
        out.source.push_back(t);
    }
    out.doubled = triangles.size() - out.source.size() - unsound;
    once.topology = std::move(topology);
    WoundOut wound = wound_out(once);
    out.triangles = std::move(wound.triangles);
    out.turned = wound.turned;
    return out;
}

TriMesh mesh_of(const TriMesh& mesh, const SolidFaces& faces)
{
    TriMesh out;
    std::vector<std::uint32_t> number(mesh.positions.size(), no_index);
    for (const Triangle& t : faces.triangles) {
        for (const std::uint32_t v : t) number[v] = 0;
    }
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] == no_index) continue;
        number[v] = static_cast<std::uint32_t>(out.positions.size());
        out.positions.push_back(mesh.positions[v]);
    }
    auto topology = std::make_shared<MeshTopology>();
    for (const auto& [a, b, c] : faces.triangles) {
        topology->triangles.push_back({number[a], number[b], number[c]});
    }
    out.topology = std::move(topology);
    return out;
}

}  // namespace geometry
