#include "physics/body/collider_features.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/meet_part.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <unordered_set>

// Map: points along an edge; boxes; vertices and edges of a mesh near a place; those that crowd.

namespace physics {
namespace {

using geometry::Box;
using geometry::Box3f;

constexpr double apart = 0.25;       // cubes, of points along an edge
constexpr double crowded = 1 / 12.;  // cubes
constexpr double sharp = 0.866;      // cosine, of faces along a sharp edge at most

bool holds(const Box& box, const Vec3& p)
{
    return (p.array() >= box.lo.array()).all() && (p.array() <= box.hi.array()).all();
}

struct Edge {
    Vec3 from, to, outward;
    std::uint32_t number;  // of its first point
    double most;           // points, besides the ends
};

// Those between the ends that lie in a box.
void add_along(const Edge& edge, const Box& region, double h, std::vector<FeaturePoint>& out)
{
    const Vec3 way = edge.to - edge.from;
    const double pieces =
        std::clamp(std::ceil(way.norm() / (apart * h) - 1e-3), 1.0, edge.most + 1);
    double begin = 0, end = 1;
    for (Eigen::Index k = 0; k < 3; ++k) {
        if (std::abs(way[k]) < 1e-9 * h) continue;
        const auto [near, far] = std::minmax(
            {(region.lo[k] - edge.from[k]) / way[k], (region.hi[k] - edge.from[k]) / way[k]});
        begin = std::max(begin, near), end = std::min(end, far);
    }
    for (double i = std::max(1.0, std::ceil(begin * pieces));
         i <= std::min(pieces - 1, std::floor(end * pieces)); ++i) {
        const Vec3 place = edge.from + i / pieces * way;
        if (!holds(region, place)) continue;
        out.push_back({edge.number + static_cast<std::uint32_t>(i) - 1, place, edge.outward});
    }
}

void add_of_box(const PosedCollider& c, const Box& region, double h, std::vector<FeaturePoint>& out)
{
    constexpr std::uint32_t of_edge = 1u << 26;
    const auto corner_at = [&](std::uint32_t k) {
        const Vec3 side((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1);
        return std::pair{Vec3(c.pose * side.cwiseProduct(c.half_size)),
                         Vec3(c.pose.linear() * side)};
    };
    std::uint32_t edges = 0;
    for (std::uint32_t a = 0; a < 8; ++a) {
        const auto [from, out_a] = corner_at(a);
        if (holds(region, from)) out.push_back({a, from, out_a.normalized()});
        for (const std::uint32_t axis : {1u, 2u, 4u}) {
            if ((a & axis) != 0) continue;
            const auto [to, out_b] = corner_at(a | axis);
            add_along({from, to, (out_a + out_b).normalized(), 8 + edges++ * of_edge, of_edge - 2},
                      region, h, out);
        }
    }
}

// A triangle near the region, with welded corners by their places in the list of near ones.
struct NearTriangle {
    std::uint32_t number = 0;
    std::array<std::uint32_t, 3> corner{};
    Vec3 normal = Vec3::Zero();  // unit
    double area = 0;             // m^2
};

// A side of a triangle; those of one edge have the same ends.
struct Side {
    std::uint64_t ends;              // the lower one in the upper half
    std::uint32_t number, triangle;  // among the sides of the mesh; of the near ones
    std::uint32_t a() const { return static_cast<std::uint32_t>(ends >> 32); }
    std::uint32_t b() const { return static_cast<std::uint32_t>(ends); }
};

// What the triangles at a corner tell.
struct AtCorner {
    Vec3 outward = Vec3::Zero();  // the sum of normals times angles
    double angles = 0;            // rad
    double steepest = 1;          // cosine, of a face to their mean
    Vec3 sides = Vec3::Zero();    // the sum of unit vectors along them
    bool on_edge = false;
};

class MeshFeatures {
public:
    MeshFeatures(const PosedCollider& c, const Box& region, double h)
        : c_(c), region_(region), h_(h)
    {
        take_triangles();
        take_corners();
        take_edges();
    }

    // Along edges, before those that crowd become one.
    double count() const
    {
        double out = 0;
        for (const Edge& edge : edges_) {
            out +=
                std::clamp(std::floor((edge.to - edge.from).norm() / (apart * h_)), 0.0, edge.most);
        }
        return out;
    }

    void add(std::vector<FeaturePoint>& out) const
    {
        std::vector<Ranked> all;
        add_edges(all);
        add_corners(all);
        std::sort(all.begin(), all.end(), [](const Ranked& a, const Ranked& b) {
            return a.bluntness != b.bluntness ? a.bluntness < b.bluntness
                                              : a.point.number < b.point.number;
        });
        std::unordered_set<std::uint64_t> taken;
        for (const Ranked& ranked : all) {
            if (taken.insert(crowd_of(ranked.point)).second) out.push_back(ranked.point);
        }
    }

private:
    struct Ranked {
        FeaturePoint point;
        double bluntness;  // 0 .. 1
    };

    Vec3 place_at(std::uint32_t v) const
    {
        const Vec3 now = c_.mesh->positions[v].cast<double>();
        if (!c_.mesh_before) return now;
        return now - c_.behind * (now - c_.mesh_before->positions[v].cast<double>());
    }
    const Vec3& place_of(std::uint32_t corner) const { return place_[corner]; }

    void take_triangles()
    {
        const Box wide = wider_by_way();
        const auto numbers = c_.tree->triangles_in({wide.lo.cast<float>(), wide.hi.cast<float>()});
        const auto& triangles = c_.mesh->topology->triangles;
        for (const auto t : numbers) {
            vertex_.insert(vertex_.end(), triangles[t].begin(), triangles[t].end());
        }
        std::sort(vertex_.begin(), vertex_.end());
        vertex_.erase(std::unique(vertex_.begin(), vertex_.end()), vertex_.end());
        for (const auto v : vertex_) place_.push_back(place_at(v));
        const std::vector<std::uint32_t> welded = weld();
        corners_.resize(vertex_.size());
        triangles_.reserve(numbers.size());
        for (const auto t : numbers) {
            NearTriangle near;
            near.number = t;
            for (std::size_t i = 0; i < 3; ++i) {
                const auto found =
                    std::lower_bound(vertex_.begin(), vertex_.end(), triangles[t][i]);
                near.corner[i] = welded[static_cast<std::size_t>(found - vertex_.begin())];
            }
            const Vec3& a = place_of(near.corner[0]);
            const Vec3 normal = (place_of(near.corner[1]) - a).cross(place_of(near.corner[2]) - a);
            near.area = normal.norm() / 2;
            if (!(near.area > 0)) continue;
            near.normal = normal / (2 * near.area);
            triangles_.push_back(near);
        }
    }

    // Corners at one place are one, with the least of their numbers.
    std::vector<std::uint32_t> weld() const
    {
        std::vector<std::pair<std::uint64_t, std::uint32_t>> by_place(vertex_.size());
        for (std::uint32_t k = 0; k < vertex_.size(); ++k) {
            by_place[k] = {hash_of(c_.mesh->positions[vertex_[k]]), k};
        }
        std::sort(by_place.begin(), by_place.end());
        std::vector<std::uint32_t> out(vertex_.size());
        for (std::size_t i = 0, begin = 0; i < by_place.size(); ++i) {
            if (by_place[i].first != by_place[begin].first) begin = i;
            const auto k = by_place[i].second;
            std::size_t same = begin;  // those of one hash are few
            while (same < i && c_.mesh->positions[vertex_[by_place[same].second]] !=
                                   c_.mesh->positions[vertex_[k]]) {
                ++same;
            }
            out[k] = by_place[same].second;
        }
        return out;
    }

    Box wider_by_way() const
    {
        Box out = region_;
        out.lo.array() -= c_.behind * c_.longest + 1e-3 * h_;
        out.hi.array() += c_.behind * c_.longest + 1e-3 * h_;
        return out;
    }

    static std::uint64_t hash_of(const geometry::Vec3f& p)
    {
        std::uint64_t out = 0;
        for (const float f : {p.x(), p.y(), p.z()}) {
            out = (out ^ std::bit_cast<std::uint32_t>(f + 0.0f)) * 0x9E3779B97F4A7C15u;
            out ^= out >> 29;
        }
        return out;
    }

    void take_corners()
    {
        for (const NearTriangle& t : triangles_) {
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3& p = place_of(t.corner[i]);
                const Vec3 u = (place_of(t.corner[(i + 1) % 3]) - p).normalized();
                const Vec3 v = (place_of(t.corner[(i + 2) % 3]) - p).normalized();
                const double angle = std::atan2(u.cross(v).norm(), u.dot(v));
                AtCorner& at = corners_[t.corner[i]];
                at.outward += angle * t.normal;
                at.angles += angle;
                at.sides += u + v;
            }
        }
        for (const NearTriangle& t : triangles_) {
            for (const auto k : t.corner) {
                AtCorner& at = corners_[k];
                at.steepest = std::min(at.steepest, t.normal.dot(at.outward.normalized()));
            }
        }
    }

    // By edge.
    std::vector<Side> sides() const
    {
        std::vector<Side> out;
        out.reserve(3 * triangles_.size());
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) {
            const NearTriangle& t = triangles_[i];
            for (std::uint32_t s = 0; s < 3; ++s) {
                const auto [a, b] = std::minmax({t.corner[s], t.corner[(s + 1) % 3]});
                if (a != b) out.push_back({std::uint64_t{a} << 32 | b, 3 * t.number + s, i});
            }
        }
        std::sort(out.begin(), out.end(), [](const Side& x, const Side& y) {
            return x.ends != y.ends ? x.ends < y.ends : x.number < y.number;
        });
        return out;
    }

    // The length of the mean normal of the faces along an edge that stands out, all of whose
    // sides these are; none of another.
    std::optional<double> bluntness_of(std::span<const Side> of_edge) const
    {
        if (of_edge.size() != 2) {  // a rim, or where several sheets meet
            return c_.sheet || of_edge.size() > 2 ? std::optional(0.0) : std::nullopt;
        }
        const NearTriangle &s = triangles_[of_edge[0].triangle],
                           &t = triangles_[of_edge[1].triangle];
        const Vec3 &from = place_of(of_edge[0].a()), &to = place_of(of_edge[0].b());
        const double turned = s.normal.dot(t.normal);
        const double cosine = c_.sheet ? std::abs(turned) : turned;  // its faces may look any way
        const double angle = std::atan2(s.normal.cross(t.normal).norm(), cosine);
        constexpr double least = 0.05;                                 // rad
        const double across = (s.area + t.area) / (to - from).norm();  // m, from middle to middle
        if (!(cosine < sharp) && !(angle > least && across < angle * h_)) return std::nullopt;
        if (!c_.sheet && !leads_out(s, t, from)) return std::nullopt;
        return (s.normal + t.normal).norm() / 2;
    }

    bool leads_out(const NearTriangle& s, const NearTriangle& t, const Vec3& from) const
    {
        double highest = -std::numeric_limits<double>::infinity(), lowest = -highest;
        for (const auto k : t.corner) {
            const double over = s.normal.dot(place_of(k) - from);
            highest = std::max(highest, over), lowest = std::min(lowest, over);
        }
        return -lowest > highest;
    }

    // Those that stand out.
    void take_edges()
    {
        constexpr double numbers = 1u << 30;
        const auto triangles = static_cast<double>(c_.mesh->topology->triangles.size());
        const auto of_edge =
            static_cast<std::uint32_t>(std::clamp(numbers / (3 * triangles), 1.0, 4096.0));
        const auto vertices = static_cast<std::uint32_t>(c_.mesh->positions.size());
        const std::vector<Side> all = sides();
        for (std::size_t i = 0; i < all.size();) {
            std::size_t end = i + 1;
            while (end < all.size() && all[end].ends == all[i].ends) ++end;
            const std::span<const Side> edge(all.data() + i, end - i);
            i = end;
            const auto bluntness = bluntness_of(edge);
            if (!bluntness) continue;
            corners_[edge[0].a()].on_edge = corners_[edge[0].b()].on_edge = true;
            Vec3 outward = Vec3::Zero();
            for (const Side& side : edge) outward += triangles_[side.triangle].normal;
            edges_.push_back({place_of(edge[0].a()), place_of(edge[0].b()), facing(outward),
                              vertices + edge[0].number * of_edge, of_edge - 1.0});
            bluntness_.push_back(*bluntness);
        }
    }

    void add_edges(std::vector<Ranked>& out) const
    {
        std::vector<FeaturePoint> points;
        for (std::size_t i = 0; i < edges_.size(); ++i) {
            points.clear();
            add_along(edges_[i], region_, h_, points);
            for (const FeaturePoint& p : points) out.push_back({p, bluntness_[i]});
        }
    }

    void add_corners(std::vector<Ranked>& out) const
    {
        for (std::uint32_t k = 0; k < corners_.size(); ++k) {
            const AtCorner& at = corners_[k];
            const Vec3& place = place_of(k);
            if (!(at.angles > 0) || !holds(region_, place)) continue;
            const bool tip = at.steepest < sharp && at.sides.dot(at.outward) < 0;
            if (!at.on_edge && !tip) continue;
            out.push_back({{vertex_[k], place, facing(at.outward)}, at.outward.norm() / at.angles});
        }
    }

    // A sheet has no side that is out.
    Vec3 facing(const Vec3& outward) const
    {
        return c_.sheet ? Vec3(Vec3::Zero()) : outward.normalized();
    }

    std::uint64_t crowd_of(const FeaturePoint& p) const
    {
        const geometry::Vec3 cell = (p.place / (crowded * h_)).array().floor();
        std::uint64_t out = 0;
        for (Eigen::Index k = 0; k < 3; ++k) {
            const auto number = static_cast<std::int64_t>(cell[k]);
            out = (out << 20) | (static_cast<std::uint64_t>(number) & 0xFFFFFu);
        }
        for (Eigen::Index k = 0; k < 3; ++k) out = (out << 1) | (p.outward[k] < 0 ? 1u : 0u);
        return out;
    }

    const PosedCollider& c_;
    const Box& region_;
    double h_;
    std::vector<std::uint32_t> vertex_;  // of the mesh, in order: those of near triangles
    std::vector<Vec3> place_;            // m, of each of them
    std::vector<AtCorner> corners_;      // of each; only welded ones have any
    std::vector<NearTriangle> triangles_;
    std::vector<Edge> edges_;
    std::vector<double> bluntness_;  // of each edge, 0 .. 1
};

}  // namespace

struct KeptFeatures::OfSize {
    double h = 0;           // m
    bool too_many = false;  // no points are kept
    std::vector<FeaturePoint> points;
    geometry::BoxTree tree;  // of the points
};

KeptFeatures::KeptFeatures() = default;
KeptFeatures::~KeptFeatures() = default;

const KeptFeatures::OfSize* KeptFeatures::find(const PosedCollider& c, double h) const
{
    constexpr double most = 5e5;  // points, before those that crowd become one
    const std::scoped_lock lock(making_);
    const auto same = [h](const auto& kept) { return kept->h == h; };
    auto kept = std::find_if(sizes_.begin(), sizes_.end(), same);
    if (kept == sizes_.end()) {
        auto made = std::make_unique<OfSize>();
        made->h = h;
        const Box all = wider(c.mesh_bounds, h);
        const MeshFeatures mesh(c, all, h);
        made->too_many = mesh.count() > most;
        if (!made->too_many) mesh.add(made->points);
        std::vector<Box3f> boxes(made->points.size());
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            boxes[i].add(made->points[i].place.cast<float>());
        }
        made->tree = geometry::build_box_tree(boxes);
        kept = sizes_.insert(sizes_.end(), std::move(made));
    }
    return (*kept)->too_many ? nullptr : kept->get();
}

static void add_of_mesh(const PosedCollider& c, const Box& region, double h,
                        std::vector<FeaturePoint>& out)
{
    const KeptFeatures::OfSize* kept = c.features ? c.features->find(c, h) : nullptr;
    if (!kept) return MeshFeatures(c, region, h).add(out);
    std::vector<std::uint32_t> found;
    kept->tree.overlapping({region.lo.cast<float>(), region.hi.cast<float>()},
                           [&](std::uint32_t i) { found.push_back(i); });
    std::sort(found.begin(), found.end());
    for (const auto i : found) {
        if (holds(region, kept->points[i].place)) out.push_back(kept->points[i]);
    }
}

Box bounds_of_features(const PosedCollider& c, double h)
{
    Box out;
    if (c.kind == Collider::Kind::mesh) return c.mesh_bounds;
    if (c.kind == Collider::Kind::box) {
        const Vec3 half = c.pose.linear().cwiseAbs() * c.half_size;
        out.add(c.pose.translation() - half);
        out.add(c.pose.translation() + half);
    }
    if (c.kind == Collider::Kind::sphere && c.radius < h) out.add(c.pose.translation());
    return out;
}

std::vector<FeaturePoint> features_in(const PosedCollider& c, const Box& region, double h)
{
    std::vector<FeaturePoint> out;
    if (c.kind == Collider::Kind::box) add_of_box(c, region, h, out);
    if (c.kind == Collider::Kind::mesh) add_of_mesh(c, region, h, out);
    if (c.kind == Collider::Kind::sphere && c.radius < h && holds(region, c.pose.translation())) {
        out.push_back({0, c.pose.translation(), Vec3::Zero(), c.radius});
    }
    return out;
}

}  // namespace physics
