#include "geometry/embed/t_junctions.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/numbering.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/embed/torn_faces.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

namespace geometry {
namespace {

// Cubes. Corners nearer to each other than this are in one place; those farther apart than some ten
// times as much are not.
constexpr double same_place = 1e-6;
constexpr double on_edge = same_place / 2;  // how near a corner is to an edge that it lies on

// Adds the faces that are not cut themselves and have an edge in common with one that is.
void add_faces_beside(const TriMesh& rest, const Cubes& cubes, CutFaces& cut)
{
    const auto& triangles = rest.triangles();
    std::vector<std::uint8_t> is_of_cut(rest.positions.size(), 0);
    for (std::size_t f = 0; f < triangles.size(); ++f) {
        if (!cut.cut[f]) continue;
        for (const auto v : triangles[f]) is_of_cut[v] = 1;
    }
    const int flat = flat_axis(cubes);
    for (std::uint32_t f = 0; f < triangles.size(); ++f) {
        if (cut.cut[f]) continue;
        const auto& t = triangles[f];
        if (is_of_cut[t[0]] + is_of_cut[t[1]] + is_of_cut[t[2]] < 2) continue;
        const Polygon face = lattice_face(rest, cubes, f, flat);
        if (!std::all_of(face.p.begin(), face.p.begin() + 3,
                         [](const Vec3& p) { return p.allFinite(); })) {
            continue;
        }
        const auto first = std::uint32_t(cut.corners.size());
        for (std::size_t k = 0; k < 3; ++k) {
            std::array<double, 3> share{};
            share[k] = 1;
            cut.corners.push_back({f, no_index, face.p[k], share});
        }
        cut.faces.push_back({first, first + 1, first + 2});
    }
}

// Numbers the places of corners. The result is a corner at each place.
std::vector<std::uint32_t> number_places(std::vector<CutFaces::Corner>& corners)
{
    // Corners go with the cell of a fine grid that they are in, and with those that they are near.
    Numbering<6> cells(corners.size());
    std::vector<std::array<std::uint32_t, 2>> joined;
    for (CutFaces::Corner& c : corners) {
        for (unsigned side = 0; side < 8; ++side) {
            std::array<std::uint32_t, 6> key;
            for (unsigned d = 0; d < 3; ++d) {
                const double at = std::clamp(c.at[Eigen::Index(d)], -1e12, 1e12);
                const double off = side >> d & 1u ? same_place : -same_place;
                const auto cell =
                    std::uint64_t(std::int64_t(std::floor((at + off) / (10 * same_place))));
                key[2 * d] = std::uint32_t(cell);
                key[2 * d + 1] = std::uint32_t(cell >> 32);
            }
            const std::uint32_t number = cells.add(key);
            if (side == 0) c.place = number;
            if (number != c.place) joined.push_back({c.place, number});
        }
    }
    UnionFind places(cells.size());
    for (const auto& [a, b] : joined) places.join(a, b);
    std::vector<std::uint32_t> number(cells.size(), no_index), corner_at;
    for (std::uint32_t c = 0; c < corners.size(); ++c) {
        std::uint32_t& place = number[places.root(corners[c].place)];
        if (place == no_index) {
            place = std::uint32_t(corner_at.size());
            corner_at.push_back(c);
        }
        corners[c].place = place;
    }
    return corner_at;
}

// An edge, by the numbers of the places of its ends, a < b, and the places between, from a to b.
struct OpenEdge {
    std::uint32_t a = 0, b = 0;
    std::vector<std::uint32_t> between;

    bool operator<(const OpenEdge& other) const
    {
        return std::tie(a, b) < std::tie(other.a, other.b);
    }
};

// The edges that faces of some part run more often in one direction than in the other: where they
// have a border, or faces of other parts beside them.
std::vector<OpenEdge> open_edges(const CutFaces& cut, std::size_t places)
{
    std::vector<Triangle> triangles;
    for (const auto& [a, b, c] : cut.faces) {
        const auto& corners = cut.corners;
        triangles.push_back({corners[a].place, corners[b].place, corners[c].place});
    }
    const std::vector<EdgeUse> uses = edge_uses(triangles, places);
    std::vector<OpenEdge> open;
    std::map<std::uint32_t, int> balance;  // of each part's faces at an edge
    for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
        const EdgeUse& first = uses[begin];
        balance.clear();
        for (; end < uses.size() && uses[end].a == first.a && uses[end].b == first.b; ++end) {
            const CutFaces::Corner& c = cut.corners[cut.faces[uses[end].triangle][0]];
            balance[c.part] += uses[end].forward ? 1 : -1;
        }
        if (std::ranges::any_of(balance, [](const auto& part) { return part.second != 0; })) {
            open.push_back({first.a, first.b, {}});
        }
    }
    return open;
}

// Finds which ends of open edges lie on others.
void find_between(const CutFaces& cut, const std::vector<std::uint32_t>& corner_at,
                  std::vector<OpenEdge>& open)
{
    const auto at = [&](std::uint32_t place) { return cut.corners[corner_at[place]].at; };
    std::vector<std::uint32_t> ends;
    for (const OpenEdge& e : open) ends.insert(ends.end(), {e.a, e.b});
    std::ranges::sort(ends);
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    std::vector<Box3f> boxes(ends.size());
    for (std::size_t k = 0; k < ends.size(); ++k) boxes[k].add(at(ends[k]).cast<float>());
    const BoxTree tree = build_box_tree(boxes);
    parallel_for(open.size(), 256, [&](std::size_t begin, std::size_t end) {
        std::vector<std::pair<double, std::uint32_t>> found;
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 from = at(open[i].a), along = at(open[i].b) - from;
            const double length = along.norm();
            Box3f box;
            box.add(from.cast<float>());
            box.add((from + along).cast<float>());
            // Twice what rounding to single precision may be.
            const float round =
                1e-5f + 3e-7f * box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs()).maxCoeff();
            box.lo.array() -= round;
            box.hi.array() += round;
            found.clear();
            tree.overlapping(box, [&](std::uint32_t item) {
                const Vec3 to = at(ends[item]) - from;
                const double t = to.dot(along) / length;
                if (t < on_edge || t > length - on_edge) return;
                if ((to - t / length * along).norm() < on_edge) found.push_back({t, ends[item]});
            });
            std::ranges::sort(found);
            for (const auto& [t, place] : found) open[i].between.push_back(place);
        }
    });
}

class Splitter {
public:
    Splitter(const std::vector<std::uint32_t>& corner_at, const std::vector<OpenEdge>& open,
             CutFaces& cut)
        : corner_at_(corner_at), open_(open), cut_(cut)
    {}

    // Splits a face where corners lie on its edges.
    void split(const Triangle& face)
    {
        std::array<std::vector<std::uint32_t>, 3> sides;
        for (std::size_t k = 0; k < 3; ++k) sides[k] = corners_between(face[k], face[(k + 1) % 3]);
        const CutFaces::Corner& corner = cut_.corners[face[0]];
        const bool splits = !sides[0].empty() || !sides[1].empty() || !sides[2].empty();
        if (splits && !corner.closes()) cut_.cut[corner.face] = 1;
        if (corner.closes() || cut_.cut[corner.face]) split(face, {sides[0], sides[1], sides[2]});
    }

    std::vector<Triangle> take() { return std::move(faces_); }

private:
    using Corners = std::span<const std::uint32_t>;

    // New corners of a face on its edge.
    std::vector<std::uint32_t> corners_between(std::uint32_t from, std::uint32_t to)
    {
        const std::uint32_t a = cut_.corners[from].place, b = cut_.corners[to].place;
        const OpenEdge wanted{std::min(a, b), std::max(a, b), {}};
        const auto found = std::lower_bound(open_.begin(), open_.end(), wanted);
        std::vector<std::uint32_t> out;
        if (found == open_.end() || wanted < *found) return out;
        for (const std::uint32_t place : found->between) {
            const CutFaces::Corner &first = cut_.corners[from], &last = cut_.corners[to];
            CutFaces::Corner c = cut_.corners[corner_at_[place]];
            if (!first.closes()) {
                const Vec3 along = last.at - first.at;
                const double t = (c.at - first.at).dot(along) / along.squaredNorm();
                c.face = first.face;
                for (std::size_t k = 0; k < 3; ++k) {
                    c.share[k] = first.share[k] + t * (last.share[k] - first.share[k]);
                }
            }
            c.part = first.part;
            c.outward = first.outward;
            out.push_back(std::uint32_t(cut_.corners.size()));
            cut_.corners.push_back(c);
        }
        if (a > b) std::ranges::reverse(out);
        return out;
    }

    // Corners on side k lie between corner k and the next, in this order.
    void split(const Triangle& face, const std::array<Corners, 3>& sides)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            const Corners side = sides[k];
            if (side.empty()) continue;
            const std::uint32_t a = face[k], b = face[(k + 1) % 3], c = face[(k + 2) % 3];
            const std::size_t half = side.size() / 2;
            split({a, side[half], c}, {side.first(half), Corners{}, sides[(k + 2) % 3]});
            split({side[half], b, c}, {side.subspan(half + 1), sides[(k + 1) % 3], Corners{}});
            return;
        }
        faces_.push_back(face);
    }

    const std::vector<std::uint32_t>& corner_at_;  // each place
    const std::vector<OpenEdge>& open_;
    CutFaces& cut_;
    std::vector<Triangle> faces_;
};

}  // namespace

void split_at_t_junctions(const TriMesh& rest, const Cubes& cubes, CutFaces& cut)
{
    add_faces_beside(rest, cubes, cut);
    const auto closes = [&](const Triangle& face) { return cut.corners[face[0]].closes(); };
    std::stable_partition(cut.faces.begin(), cut.faces.end(), std::not_fn(closes));
    const std::vector<std::uint32_t> corner_at = number_places(cut.corners);
    std::vector<OpenEdge> open = open_edges(cut, corner_at.size());
    find_between(cut, corner_at, open);
    Splitter splitter(corner_at, open, cut);
    for (const Triangle& face : cut.faces) splitter.split(face);
    cut.faces = splitter.take();
}

}  // namespace geometry
