#include "geometry/cubes/glued_pieces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/cubes/piece_meetings.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <utility>

namespace geometry {
namespace {

constexpr std::size_t most_pairs = 256;
constexpr std::size_t most_points = 256;  // of a piece of a pair
constexpr double touching = 0.05;         // cubes: what is nearer than this is one body

// Some of the points, evenly.
void thin_out(std::vector<Vec3>& points)
{
    const std::size_t step = points.size() / most_points + 1;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); i += step) points[kept++] = points[i];
    points.resize(kept);
}

Box box_of(std::span<const Vec3> points)
{
    Box box;
    for (const Vec3& p : points) box.add(p);
    return box;
}

// The triangles of the pieces that are looked at: those near where pieces meet, and all.
class Triangles {
public:
    Triangles(const PlacedMesh& all, const PieceMeetings& meetings)
        : all_(all), near_(all.pieces.count()), box_(all.pieces.count()),
          near_box_(all.pieces.count()), number_(all.mesh.positions.size(), no_index)
    {
        std::vector<std::uint8_t> wanted(all.pieces.count(), 0);
        for (const PiecePair& pair : meetings.pairs) wanted[pair[0]] = wanted[pair[1]] = 1;
        for (std::uint32_t v = 0; v < all.piece.size(); ++v) {
            if (all.piece[v] != no_index && wanted[all.piece[v]] != 0) {
                box_[all.piece[v]].add(all.point(v));
            }
        }
        for (std::uint32_t t = 0; t < all.pieces.of.size(); ++t) {
            const std::uint32_t piece = all.pieces.of[t];
            if (piece == no_index || wanted[piece] == 0) continue;
            if (!meetings.any(all.cubes_of(t), PieceMeetings::beside)) continue;
            near_[piece].push_back(t);
            for (const std::uint32_t v : all.mesh.triangles()[t])
                near_box_[piece].add(all.point(v));
        }
    }

    const Box& box(std::uint32_t piece) const { return box_[piece]; }
    const Box& near_box(std::uint32_t piece) const { return near_box_[piece]; }

    // Of a piece's triangles near meetings, at least those within `reach` (m) of a point.
    TriangleBvh near(std::uint32_t piece, std::span<const Vec3> points, double reach)
    {
        constexpr std::size_t some = 16;  // points that follow each other lie near each other
        std::vector<Box> around;
        for (std::size_t i = 0; i < points.size(); i += some) {
            around.push_back(box_of(points.subspan(i, std::min(some, points.size() - i))));
        }
        std::vector<Triangle> within;
        for (const std::uint32_t t : near_[piece]) {
            Box own;
            for (const std::uint32_t v : all_.mesh.triangles()[t]) own.add(all_.point(v));
            const bool reached = std::any_of(around.begin(), around.end(), [&](const Box& box) {
                return (own.lo - box.hi).cwiseMax(box.lo - own.hi).maxCoeff() <= reach;
            });
            if (reached) within.push_back(all_.mesh.triangles()[t]);
        }
        return tree_of(std::move(within));
    }

    const TriangleBvh& whole(std::uint32_t piece)
    {
        const auto known = whole_.find(piece);
        if (known != whole_.end()) return known->second;
        std::vector<Triangle> some;
        for (std::size_t t = 0; t < all_.pieces.of.size(); ++t) {
            if (all_.pieces.of[t] == piece) some.push_back(all_.mesh.triangles()[t]);
        }
        return whole_.emplace(piece, tree_of(std::move(some))).first->second;
    }

private:
    TriangleBvh tree_of(std::vector<Triangle> triangles)
    {
        MeshTopology topology;
        TriMesh out;
        std::vector<std::uint32_t> used;
        for (Triangle& triangle : triangles) {
            for (std::uint32_t& v : triangle) {
                if (number_[v] == no_index) {
                    number_[v] = static_cast<std::uint32_t>(used.size());
                    used.push_back(v);
                    out.positions.push_back(all_.mesh.positions[v]);
                }
                v = number_[v];
            }
        }
        for (const std::uint32_t v : used) number_[v] = no_index;
        topology.triangles = std::move(triangles);
        out.topology = std::make_shared<const MeshTopology>(std::move(topology));
        return TriangleBvh(out);
    }

    const PlacedMesh& all_;
    std::vector<std::vector<std::uint32_t>> near_;
    std::vector<Box> box_, near_box_;    // P, of all triangles and of those near meetings
    std::vector<std::uint32_t> number_;  // V, scratch: all no_index
    std::map<std::uint32_t, TriangleBvh> whole_;
};

// The shortest way between two pieces.
struct Gap {
    double distance = std::numeric_limits<double>::infinity();  // m; 0: they overlap
    double along = 0;                                           // m, its largest part along an axis
    Vec3 where = Vec3::Zero();
};

double distance_to(const Box& box, const Vec3& p)
{
    return (box.lo - p).cwiseMax(p - box.hi).cwiseMax(0).norm();
}

// Between points of the two, until it is below `enough` (m): the way between the surfaces is no
// longer.
double between_points(const std::array<std::vector<Vec3>, 2>& points, double enough)
{
    double least = std::numeric_limits<double>::infinity();
    const Box box = box_of(points[1]);
    for (const Vec3& p : points[0]) {
        if (least < enough) break;
        if (distance_to(box, p) >= least) continue;
        double nearest_sq = least * least;
        for (const Vec3& q : points[1]) nearest_sq = std::min(nearest_sq, (p - q).squaredNorm());
        least = std::sqrt(nearest_sq);
    }
    return least;
}

// How the piece that points are measured to closes up.
struct Closure {
    bool encloses = false, inside_out = false;
};

// From the points to the piece in the tree, within `reach` (m), until the gap is below `enough`.
void shorten(const std::vector<Vec3>& points, const TriangleBvh& tree, const Closure& piece,
             double enough, double reach, Gap& gap)
{
    for (const Vec3& p : points) {
        if (gap.distance < enough) return;
        const TriangleBvh::Hit hit = tree.closest(p, std::min(gap.distance, reach));
        if (!hit) continue;
        const bool inside = piece.encloses && hit.behind != piece.inside_out;
        gap.distance = inside ? 0 : hit.distance;
        gap.where = 0.5 * (hit.point + p);
        gap.along = (hit.point - p).cwiseAbs().maxCoeff();
    }
}

// Exact where it is shorter than the way between points of the two: what is farther is not looked
// at, but for points that may lie deep inside the other piece.
Gap gap_of(const PiecePair& pair, const std::array<std::vector<Vec3>, 2>& points,
           const Pieces& pieces, double enough, Triangles& triangles)
{
    Gap gap;
    const double reach = 1.001 * between_points(points, enough);
    if (reach < enough) {
        gap.distance = 0;
        return gap;
    }
    const auto closure = [&](std::uint32_t piece) {
        return Closure{pieces.encloses[piece] != 0, pieces.volume[piece] < 0};
    };
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
        const std::uint32_t to = pair[1 - k];
        if (points[k].empty() || gap.distance < enough) continue;
        const double within = std::min(reach, gap.distance);
        std::vector<Vec3> some;
        for (const Vec3& p : points[k]) {
            if (distance_to(triangles.near_box(to), p) <= within) some.push_back(p);
        }
        if (some.empty()) continue;
        const TriangleBvh tree = triangles.near(to, some, within);
        shorten(some, tree, closure(to), enough, within, gap);
    }
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
        const std::uint32_t to = pair[1 - k];
        if (gap.distance < enough || !closure(to).encloses) continue;
        const bool outside = std::all_of(points[k].begin(), points[k].end(), [&](const Vec3& p) {
            return distance_to(triangles.box(to), p) > 0;
        });
        if (outside) continue;
        Gap whole;
        shorten(points[k], triangles.whole(to), closure(to), enough, whole.distance, whole);
        if (whole.distance < gap.distance) gap = whole;
    }
    return gap;
}

double two_digits_below(double x)
{
    const double digit = std::pow(10, std::floor(std::log10(x)) - 1);
    return std::floor(x / digit) * digit;
}

}  // namespace

GluedPieces find_glued_pieces(const TriMesh& mesh, const Pieces& pieces, const Cubes& cubes,
                              double join)
{
    GluedPieces out;
    if (pieces.count() < 2) return out;
    const PlacedMesh all = place_mesh(mesh, pieces, cubes);
    const PieceMeetings meetings = find_piece_meetings(all, most_pairs);
    if (meetings.pairs.empty()) return out;
    std::vector<std::array<std::vector<Vec3>, 2>> points = points_of_pairs(all, meetings);
    Triangles triangles(all, meetings);
    UnionFind bodies(pieces.count());
    std::vector<std::pair<PiecePair, Gap>> apart;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const PiecePair& pair = meetings.pairs[i];
        if (bodies.root(pair[0]) == bodies.root(pair[1])) continue;
        for (std::vector<Vec3>& some : points[i]) thin_out(some);
        const double enough = touching * cubes.size + join;
        const Gap gap = gap_of(pair, points[i], pieces, enough, triangles);
        if (gap.distance < enough) {
            bodies.join(pair[0], pair[1]);
        } else if (std::isfinite(gap.distance)) {
            apart.emplace_back(pair, gap);
        }
    }
    std::set<std::uint32_t> glued;
    for (const auto& [pair, gap] : apart) {
        if (bodies.root(pair[0]) == bodies.root(pair[1])) continue;
        glued.insert(pair.begin(), pair.end());
        if (out.size > 0 && gap.distance >= out.gap) continue;
        out.pair = pair;
        out.gap = gap.distance;
        out.where = gap.where;
        out.size = two_digits_below(0.95 * gap.along / 2);  // a plane of corners lies between them
    }
    out.count = glued.size();
    out.at_least = meetings.pairs.size() == most_pairs;
    return out;
}

}  // namespace geometry
