#include "geometry/mesh/doubled_faces.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/mesh/cut_alike.hpp"
#include "geometry/mesh/first_in_place.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace geometry {
namespace {

// A triangle by its places, in ascending order, and whether it runs through them so.
struct Placed {
    std::array<std::uint32_t, 3> places;
    std::uint16_t kind = 0;
    bool forward = true;
    std::uint32_t triangle = 0;
    std::uint32_t face = 0;  // by its places alone, in the order of those

    bool operator<(const Placed& o) const
    {
        return std::tie(places, kind, forward, triangle) <
               std::tie(o.places, o.kind, o.forward, o.triangle);
    }
};

Placed placed(const Triangle& t, std::uint16_t kind, std::uint32_t number)
{
    Placed out{{t[0], t[1], t[2]}, kind, true, number};
    auto& p = out.places;
    const auto order = [&](std::size_t a, std::size_t b) {
        if (p[b] < p[a]) std::swap(p[a], p[b]), out.forward = !out.forward;
    };
    order(0, 1), order(1, 2), order(0, 1);
    return out;
}

using Group = std::span<const Placed>;

// Calls f with each run of triangles in the same places; `by_kind`: and of one kind.
template <class F> void for_each_group(const std::vector<Placed>& all, bool by_kind, const F& f)
{
    StopCheck check;
    for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
        check();
        end = i + 1;
        while (end < all.size() && all[end].places == all[i].places &&
               (!by_kind || all[end].kind == all[i].kind)) {
            ++end;
        }
        f(Group(all).subspan(i, end - i));
    }
}

bool has_both_ways(Group group)
{
    return group.front().forward != group.back().forward;
}

// Numbers the faces; how many there are, and whether one of them has a back.
std::pair<std::uint32_t, bool> number_faces(std::vector<Placed>& all)
{
    std::uint32_t faces = 0;
    bool any_back = false;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const bool next = i == 0 || all[i].places != all[i - 1].places;
        faces += next ? 1 : 0;
        any_back |= !next && all[i].forward != all[i - 1].forward;
        all[i].face = faces - 1;
    }
    return {faces, any_back};
}

struct FaceEdge {
    std::uint32_t a, b, face;

    bool operator<(const FaceEdge& o) const
    {
        return std::tie(a, b, face) < std::tie(o.a, o.b, o.face);
    }
};

std::vector<FaceEdge> sorted_edges(const std::vector<Placed>& all)
{
    std::vector<FaceEdge> edges;
    for_each_group(all, false, [&](Group group) {
        const auto& [a, b, c] = group.front().places;  // ascending
        const std::uint32_t face = group.front().face;
        edges.insert(edges.end(), {{a, b, face}, {b, c, face}, {a, c, face}});
    });
    std::sort(edges.begin(), edges.end());
    return edges;
}

// Pieces of faces that share edges, by the number of each face's. `plain`: those that are not
// two-sided, as some of their triangles have none against them. `open`: those with a border, an
// edge of one face.
struct TwoSided {
    std::vector<std::uint32_t> piece;
    std::vector<std::uint8_t> plain, open;

    std::uint32_t of(const Placed& p) const { return piece[p.face]; }
};

TwoSided one_plain_piece(std::uint32_t faces)
{
    return {std::vector<std::uint32_t>(faces, 0), {1}, {0}};
}

TwoSided find_two_sided(const std::vector<Placed>& all, std::uint32_t faces)
{
    const std::vector<FaceEdge> edges = sorted_edges(all);
    UnionFind joined(faces);
    const auto same = [](const FaceEdge& e, const FaceEdge& f) { return e.a == f.a && e.b == f.b; };
    for (std::size_t i = 1; i < edges.size(); ++i) {
        if (same(edges[i - 1], edges[i])) joined.join(edges[i - 1].face, edges[i].face);
    }
    TwoSided out;
    out.piece = joined.roots();
    out.plain.assign(faces, 0);
    out.open.assign(faces, 0);
    for_each_group(all, true, [&](Group group) {
        if (!has_both_ways(group)) out.plain[out.of(group.front())] = 1;
    });
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const bool alone = (i == 0 || !same(edges[i - 1], edges[i])) &&
                           (i + 1 == edges.size() || !same(edges[i], edges[i + 1]));
        if (alone) out.open[out.piece[edges[i].face]] = 1;
    }
    return out;
}

// Of triangles in the same places and of one kind the first stays.
void mark(Group group, const TwoSided& pieces, std::vector<Doubled>& is)
{
    const Placed& first =
        *std::min_element(group.begin(), group.end(),
                          [](const Placed& a, const Placed& b) { return a.triangle < b.triangle; });
    const std::uint32_t piece = pieces.of(first);
    const Doubled back = pieces.plain[piece] != 0  ? Doubled::against
                         : pieces.open[piece] != 0 ? Doubled::sheet_back
                                                   : Doubled::solid_back;
    bool one_back = false;
    for (const Placed& p : group) {
        if (p.triangle == first.triangle) continue;
        const bool is_back = p.forward != first.forward && !one_back;
        one_back |= is_back;
        is[p.triangle] = is_back ? back : Doubled::again;
    }
}

}  // namespace

DoubledFaces doubled_faces(const TriMesh& mesh, std::span<const std::uint16_t> kind)
{
    const std::size_t count = mesh.positions.size();
    const auto sound = [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](std::uint32_t v) {
            return v < count && mesh.positions[v].allFinite();
        });
    };
    const auto place = first_in_place(std::span<const Vec3f>(mesh.positions));
    DoubledFaces out{mesh.triangles(), {}};
    out.is.assign(out.triangles.size(), Doubled::no);
    for (std::size_t t = 0; t < out.triangles.size(); ++t) {
        if (!sound(out.triangles[t])) out.is[t] = Doubled::unsound;
        for (auto& v : out.triangles[t]) v = out.is[t] == Doubled::unsound ? 0 : place[v];
    }
    stop_if_asked();
    cut_alike(out.triangles, mesh.topology->polygon, mesh.positions);
    std::vector<Placed> all;
    all.reserve(out.triangles.size());
    for (std::uint32_t t = 0; t < out.triangles.size(); ++t) {
        if (out.is[t] == Doubled::unsound) continue;
        all.push_back(placed(out.triangles[t], kind.empty() ? std::uint16_t{0} : kind[t], t));
    }
    std::sort(all.begin(), all.end());
    stop_if_asked();
    const auto [faces, any_back] = number_faces(all);
    const TwoSided pieces = any_back ? find_two_sided(all, faces) : one_plain_piece(faces);
    for_each_group(all, true, [&](Group group) { mark(group, pieces, out.is); });
    return out;
}

std::size_t count_sheet_backs(const TriMesh& mesh, std::span<const std::uint16_t> kind)
{
    const std::vector<Doubled> is = doubled_faces(mesh, kind).is;
    return static_cast<std::size_t>(std::count(is.begin(), is.end(), Doubled::sheet_back));
}

std::optional<WithoutDoubled> without_doubled(const TriMesh& mesh,
                                              std::span<const std::uint16_t> kind)
{
    const DoubledFaces faces = doubled_faces(mesh, kind);
    std::vector<std::uint32_t> of;
    of.reserve(faces.is.size());
    std::size_t doubled = 0;
    for (const Doubled is : faces.is) {
        of.push_back(adds_to_surface(is) ? 0 : 1);
        if (!adds_to_surface(is) && is != Doubled::unsound) ++doubled;
    }
    if (doubled == 0) return std::nullopt;
    return WithoutDoubled{std::move(split(mesh, of, 1)[0]), doubled};
}

}  // namespace geometry
