#include "physics/body/sheet_edges.hpp"

#include "geometry/mesh/mesh.hpp"
#include "physics/body/flat_cells.hpp"
#include "physics/body/solids_beside_sheets.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <tuple>

// Map: planes of a collider; where a segment or a triangle meets several; what may meet; its touch.

namespace physics {
namespace {

using geometry::Mat3;

constexpr double near_side = 0.75;     // sides, that one of its ends is nearer than
constexpr double alike_faces = 0.866;  // cosine: planes that meet in an edge differ by 30 degrees
constexpr double same_face = 0.999;    // cosine
constexpr double on_collider = 0.01;   // of a side of a cell
constexpr double same_side = 0.3;      // cosine
constexpr double least_angle = 0.3;    // sine, of a side that crosses an edge
constexpr double least_length = 0.2;   // of the mean of two normals that look different ways
constexpr std::uint32_t cell_numbers = 8;  // of a cell: 5 sides, 2 triangles
constexpr std::uint32_t first_triangle = 5;

// A plane before which the collider does not come, as seen from a place.
struct FacePlane {
    Vec3 normal;
    double offset;                 // m
    Vec3 velocity = Vec3::Zero();  // m/s, of the collider there

    double gap(const Vec3& p) const { return normal.dot(p) - offset; }
};

// Across the way from the nearest place of a mesh to p: at an edge its own normal looks elsewhere.
std::optional<FacePlane> plane_of_mesh(const PosedCollider& c, const Vec3& p)
{
    const auto hit = c.tree->closest(p, c.reach + c.thickness);
    if (!hit) return std::nullopt;
    Vec3 normal = hit.normal, moved = Vec3::Zero();
    if (!hit.behind && hit.distance > 1e-6 * c.reach) normal = (p - hit.point) / hit.distance;
    if (c.mesh_before && c.frame > 0) {
        const auto& corners = c.mesh->topology->triangles[hit.triangle];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto k = corners[i];
            moved += hit.barycentric[static_cast<Eigen::Index>(i)] *
                     (c.mesh->positions[k] - c.mesh_before->positions[k]).cast<double>();
        }
        moved /= c.frame;
    }
    const double gap = hit.signed_distance() + c.behind * c.frame * moved.dot(normal);
    return FacePlane{normal, normal.dot(p) - gap, moved};
}

std::optional<FacePlane> plane_at(const PosedCollider& c, const Vec3& p)
{
    if (c.kind == Collider::Kind::mesh) return plane_of_mesh(c, p);
    const Touch t = touch(c, p);
    return FacePlane{t.normal, t.normal.dot(p) - t.gap - c.thickness, t.velocity};
}

// On the side of the collider that `side` looks to; none where the nearest place is on another.
std::optional<FacePlane> plane_at(const PosedCollider& c, const Vec3& p, const Vec3& side)
{
    std::optional<FacePlane> out = plane_at(c, p);
    if (out && c.sheet && out->normal.dot(side) < 0) {
        out->normal = -out->normal, out->offset = -out->offset;
    }
    if (out && !(out->normal.dot(side) > same_side)) return std::nullopt;
    return out;
}

// Where a side or a triangle is nearest to a collider, with shares of its three corners.
struct OverEdge {
    Vec3 share = Vec3::Zero();
    FacePlane plane;  // towards what meets it
    double gap = 0;
};

// Two planes, of which `a` falls from p along d and b rises.
std::optional<OverEdge> over_edge(const FacePlane& a, const FacePlane& b, const Vec3& p,
                                  const Vec3& d)
{
    const double falls = -a.normal.dot(d), rises = b.normal.dot(d);
    if (!(falls > 0 && rises > 0)) return std::nullopt;
    const Vec3 edge = a.normal.cross(b.normal);
    if (edge.cross(d).norm() < least_angle * edge.norm() * d.norm()) return std::nullopt;
    const double part = rises / (rises + falls);
    const Vec3 sum = part * a.normal + (1 - part) * b.normal;
    const double length = sum.norm();
    if (!(length > least_length)) return std::nullopt;
    const Vec3 n = sum / length;
    const double gap = (part * a.gap(p) + (1 - part) * b.gap(p)) / length;
    const double share = (a.gap(p) - gap * a.normal.dot(n)) / falls;
    return OverEdge{{1 - share, share, 0}, {n, n.dot(p) - gap, a.velocity}, gap};
}

// Where the side from p along d is nearest to a collider that ends see behind those planes; none
// where that is an end, or it is not nearer than `near` (m).
std::optional<OverEdge> meet_side(const PosedCollider& c, std::array<FacePlane, 2> ends,
                                  const Vec3& p, const Vec3& d, double near)
{
    constexpr int most = 5;
    constexpr double level = 0.02;     // of the side: nearly along the plane
    constexpr double opposite = -0.5;  // cosine: what they meet in is far outside
    std::optional<OverEdge> out;
    if (ends[0].normal.dot(ends[1].normal) < opposite) {
        const auto rim = plane_at(c, p + d / 2);
        if (!rim) return std::nullopt;
        ends[rim->normal.dot(d) < 0 ? 0 : 1] = *rim;
    }
    for (int round = 0; round < most; ++round) {
        const auto next = over_edge(ends[0], ends[1], p, d);
        if (!next || !(next->gap < near)) return std::nullopt;
        out = next;
        const double share = std::clamp(out->share[1], 0.0, 1.0);
        const Vec3 there = p + share * d;
        const auto seen = plane_at(c, there, out->plane.normal);
        if (!seen) {
            // Beside what the planes bound, as below the rim of a wheel that both ends see from
            // outside: nothing is met there.
            const auto any = c.sheet ? std::nullopt : plane_at(c, there);
            if (any && any->gap(there) > 0) return std::nullopt;
            break;
        }
        out->plane.velocity = seen->velocity;
        const double along = seen->normal.dot(d);
        if (std::max(seen->normal.dot(ends[0].normal), seen->normal.dot(ends[1].normal)) >
            same_face) {
            break;
        }
        if (std::abs(along) < level * d.norm()) {  // as over an edge, or where it is round
            out->plane.normal = seen->normal;
            out->gap = seen->gap(there);
            out->share = {1 - share, share, 0};
            break;
        }
        ends[along < 0 ? 0 : 1] = *seen;
    }
    const bool within = out->share[1] > 0 && out->share[1] < 1;
    return within && out->gap < near ? out : std::nullopt;
}

// A triangle of a sheet.
struct Spanned {
    explicit Spanned(const std::array<Vec3, 3>& p)
        : from(p[0]), u(p[1] - p[0]), v(p[2] - p[0]), normal(u.cross(v).normalized())
    {}
    // Shares of its corners, of the foot of a way from the first one; of the way itself where
    // `one` is 0.
    Vec3 shares(const Vec3& way, double one) const
    {
        const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
        const double b = (vv * u.dot(way) - uv * v.dot(way)) / det;
        const double d = (uu * v.dot(way) - uv * u.dot(way)) / det;
        return {one - b - d, b, d};
    }
    double size() const { return std::max(u.norm(), v.norm()); }

    Vec3 from, u, v, normal;
};

// The planes in which an edge ends, that two planes meet in, over a triangle: where the edge goes
// in or comes out of what is over that, the collider may be there no more.
std::array<std::optional<FacePlane>, 2> ends_of_edge(const PosedCollider& c, const FacePlane& a,
                                                     const FacePlane& b, const Spanned& triangle)
{
    constexpr double far = 4;  // sizes of the triangle: the edge is across it
    const Vec3 along = a.normal.cross(b.normal).normalized();
    Mat3 rows;
    rows << a.normal.transpose(), b.normal.transpose(), along.transpose();
    const Vec3 on = rows.inverse() * Vec3(a.offset, b.offset, along.dot(triangle.from));
    const Vec3 start = triangle.shares(on - triangle.from, 1), slope = triangle.shares(along, 0);
    double in = -far * triangle.size(), out = -in;
    for (Eigen::Index i = 0; i < 3; ++i) {
        if (slope[i] > 0) in = std::max(in, -start[i] / slope[i]);
        if (slope[i] < 0) out = std::min(out, -start[i] / slope[i]);
        if (slope[i] == 0 && start[i] < 0) return {};
    }
    if (!(in < out) || out - in > far * triangle.size()) return {};
    std::array<std::optional<FacePlane>, 2> ends{plane_at(c, on + in * along),
                                                 plane_at(c, on + out * along)};
    for (std::size_t i = 0; i < 2; ++i) {
        const Vec3 p = on + (i == 0 ? in : out) * along;
        if (ends[i] && !(ends[i]->gap(p) > on_collider * triangle.size())) ends[i].reset();
    }
    return ends;
}

// The place of a triangle that a corner stands over, `gap` (m) before it. A corner that stands out
// where the sheet is folded, or has a tip, may be a bit beside each of the triangles there.
std::optional<Vec3> shares_under(const Vec3& corner, double gap, const Spanned& triangle)
{
    constexpr double beside = 2;  // depths
    const Vec3 shares = triangle.shares(corner - triangle.from, 1);
    if (shares.minCoeff() > 0) return shares;
    Vec3 within = shares.cwiseMax(0);
    within /= within.sum();
    const Vec3 off = within - shares;
    if ((off[1] * triangle.u + off[2] * triangle.v).norm() > -beside * gap) return std::nullopt;
    return within;
}

// Where the corner in which three planes meet stands under a triangle; none where there is none.
std::optional<OverEdge> over_corner(const PosedCollider& c, const std::array<FacePlane, 3>& planes,
                                    const Spanned& triangle)
{
    constexpr double least_open = 0.02;  // the determinant of normals
    Mat3 normals;
    for (Eigen::Index i = 0; i < 3; ++i) normals.col(i) = planes[std::size_t(i)].normal;
    if (!(std::abs(normals.determinant()) > least_open)) return std::nullopt;
    const Mat3 inverse = normals.inverse();
    Vec3 n = triangle.normal, parts = inverse * n;
    if (parts.maxCoeff() < 0) n = -n, parts = -parts;
    if (!(parts.minCoeff() > 0)) return std::nullopt;
    const Vec3 offsets(planes[0].offset, planes[1].offset, planes[2].offset);
    const Vec3 corner = inverse.transpose() * offsets;
    const double gap = n.dot(triangle.from - corner);
    const auto shares = shares_under(corner, gap, triangle);
    if (!shares) return std::nullopt;
    const auto seen = plane_at(c, corner);
    if (!seen || std::abs(seen->gap(corner)) > on_collider * triangle.size()) return std::nullopt;
    return OverEdge{*shares, {n, n.dot(corner), seen->velocity}, gap};
}

// Where a triangle is nearest to a corner of the collider that its own corners see behind those
// planes; none where it is not nearer than `near` (m).
std::optional<OverEdge> meet_triangle(const PosedCollider& c,
                                      const std::array<FacePlane, 3>& planes,
                                      const std::array<Vec3, 3>& p, double near)
{
    const Spanned triangle(p);
    auto out = over_corner(c, planes, triangle);
    for (std::size_t i = 0; i < 3 && !out; ++i) {
        const FacePlane &a = planes[i], &b = planes[(i + 1) % 3];
        if (!(a.normal.dot(b.normal) < alike_faces)) continue;
        for (const auto& end : ends_of_edge(c, a, b, triangle)) {
            if (end && !out) out = over_corner(c, {a, b, *end}, triangle);
        }
    }
    return out && out->gap < near ? out : std::nullopt;
}

// A side or a triangle of a cell that may meet a collider: the slots of its two or three corners.
struct EdgePair {
    std::array<std::uint32_t, 3> corner;
    std::uint32_t other, point, cell;
    bool is_side() const { return corner[1] == corner[2]; }
};

// The stands of the corners to one collider, by slot. `of`: of each slot, nothing but while this
// lives.
class StandsOnCollider {
public:
    using Stands = std::span<const CornerStand* const>;

    StandsOnCollider(const SheetOverEdges& scene, Stands stands,
                     std::vector<const CornerStand*>& of)
        : scene_(scene), other_(stands.front()->other), stands_(stands), of_(of)
    {
        for (const CornerStand* stand : stands_) of_[stand->slot] = stand;
    }
    StandsOnCollider(const StandsOnCollider&) = delete;
    StandsOnCollider& operator=(const StandsOnCollider&) = delete;
    ~StandsOnCollider()
    {
        for (const CornerStand* stand : stands_) of_[stand->slot] = nullptr;
    }
    std::uint32_t other() const { return other_; }
    // The cells of these corners.
    std::vector<std::uint32_t> cells(const FlatCells& flat) const
    {
        std::vector<std::uint32_t> out;
        for (const CornerStand* stand : stands_) {
            const auto at = flat.at(stand->slot);
            out.insert(out.end(), at.begin(), at.end());
        }
        std::sort(out.begin(), out.end());
        out.erase(std::unique(out.begin(), out.end()), out.end());
        return out;
    }
    // What a corner sees of the collider, be it too far to have a stand.
    std::optional<FacePlane> plane(std::uint32_t slot) const
    {
        const Vec3 p = corner_place(scene_.x, slot);
        const PosedCollider& c = scene_.colliders[other_];
        const CornerStand* const stand = of_[slot];
        if (!stand) return c.sheet ? std::nullopt : plane_at(c, p);
        if (c.kind == Collider::Kind::mesh && stand->gap > 0) {
            if (const auto out = plane_at(c, p, stand->normal)) return out;
        }
        return FacePlane{stand->normal, stand->normal.dot(p) - stand->gap, stand->velocity};
    }
    // Whether they lie on one face, as most do.
    bool are_level(const EdgePair& pair) const
    {
        constexpr double low = 0.1;  // sides: two that lie on an edge from both sides are higher
        const CornerStand* const first = of_[pair.corner[0]];
        if (!first) return false;
        const Vec3 from = corner_place(scene_.x, pair.corner[0]);
        for (const auto k : {pair.corner[1], pair.corner[2]}) {
            const CornerStand* const next = of_[k];
            if (!next || next->normal.dot(first->normal) < same_face) return false;
            const Vec3 way = corner_place(scene_.x, k) - from;
            const double much = low * way.norm();
            const double off = next->gap - first->gap - first->normal.dot(way);
            const double thickness = scene_.colliders[other_].thickness;
            if (std::max(first->gap, next->gap) > thickness + much || std::abs(off) > much) {
                return false;
            }
        }
        return true;
    }
    // Whether one of them is so near that an edge may come between them.
    bool are_near(const EdgePair& pair) const
    {
        double length = 0, gap = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t next = (i + 1) % 3;
            length = std::max(length, (corner_place(scene_.x, pair.corner[next]) -
                                       corner_place(scene_.x, pair.corner[i]))
                                          .norm());
            if (const auto* stand = of_[pair.corner[i]]) gap = std::min(gap, stand->gap);
        }
        return gap < near_side * length + scene_.colliders[other_].thickness;
    }

private:
    const SheetOverEdges& scene_;
    std::uint32_t other_;
    Stands stands_;
    std::vector<const CornerStand*>& of_;
};

// The sides and triangles of all cells that are near one collider: each side once.
std::vector<EdgePair> pairs_of(const SheetOverEdges& scene, const StandsOnCollider& stands,
                               const FlatCells& flat)
{
    std::vector<EdgePair> out;
    const ContactSurface& surface = scene.body.skin;
    const std::size_t last = surface.corners.size() - 1;
    const SurfacePatch& patch = surface.on(last);
    const std::uint32_t first = surface.first_point[last] + patch.points_end - patch.point;
    const std::uint32_t other = stands.other();
    for (const std::uint32_t c : stands.cells(flat)) {
        const auto& k = flat.corner[c];
        const std::uint32_t cell = flat.cell[c];
        const std::uint32_t point = first + cell_numbers * cell;
        std::uint32_t number = 0;
        for (const auto& [i, j] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {0, 3}}) {
            const auto a = std::min(k[std::size_t(i)], k[std::size_t(j)]);
            const auto b = std::max(k[std::size_t(i)], k[std::size_t(j)]);
            const EdgePair pair{{a, b, b}, other, point + number++, cell};
            if (a != b && stands.are_near(pair) && !stands.are_level(pair)) out.push_back(pair);
        }
        for (const std::uint32_t t : {0u, 1u}) {
            const EdgePair pair{{k[0], k[t == 0 ? 1 : 3], k[t == 0 ? 3 : 2]},
                                other,
                                point + first_triangle + t,
                                cell};
            if (pair.corner[1] == pair.corner[2]) continue;
            if (stands.are_near(pair) && !stands.are_level(pair)) out.push_back(pair);
        }
    }
    std::sort(out.begin(), out.end(), [](const EdgePair& a, const EdgePair& b) {
        return std::tie(a.corner, a.point) < std::tie(b.corner, b.point);
    });
    const auto same_corners = [](const auto& a, const auto& b) { return a.corner == b.corner; };
    out.erase(std::unique(out.begin(), out.end(), same_corners), out.end());
    return out;
}

std::optional<OverEdge> over_edges_of(const SheetOverEdges& scene, const StandsOnCollider& stands,
                                      const EdgePair& pair, double near)
{
    const PosedCollider& c = scene.colliders[pair.other];
    std::array<FacePlane, 3> planes;
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < (pair.is_side() ? 2 : 3); ++i) {
        const auto plane = stands.plane(pair.corner[i]);
        if (!plane) return std::nullopt;
        planes[i] = *plane, p[i] = corner_place(scene.x, pair.corner[i]);
    }
    const auto differ = [&](std::size_t i, std::size_t k) {
        return planes[i].normal.dot(planes[k].normal) < alike_faces;
    };
    if (!pair.is_side()) return c.sheet ? std::nullopt : meet_triangle(c, planes, p, near);
    if (!differ(0, 1)) return std::nullopt;
    return meet_side(c, {planes[0], planes[1]}, p[0], p[1] - p[0], near);
}

std::optional<PlaneTouch> edge_touch(const SheetOverEdges& scene, const EdgePair& pair,
                                     const OverEdge& meeting)
{
    const ContactSurface& surface = scene.body.skin;
    const PosedCollider& c = scene.colliders[pair.other];
    const double h = scene.body.edge_at(pair.corner[0]);
    PlaneTouch out;
    out.count = 8;
    out.corners = {};
    out.corners.fill(pair.corner[0]);
    Vec3 p = Vec3::Zero(), velocity = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
        const double weight = meeting.share[static_cast<Eigen::Index>(i)];
        out.corners[i] = pair.corner[i];
        out.weight[i] = static_cast<float>(weight);
        p += weight * corner_place(scene.x, pair.corner[i]);
        velocity += weight * corner_place(scene.v, pair.corner[i]);
    }
    const FacePlane& plane = meeting.plane;
    const double way = scene.dt * (plane.velocity - velocity).dot(plane.normal);  // in, m
    // It stands for a part of a cell: stiffer at rest, it makes a cloth on a table swing for good
    // at a step a frame.
    constexpr double resting = 0.15, hit = 0.5, deep = 0.2;  // deep: cells
    const double part = resting + (hit - resting) * std::clamp(way / (deep * h), 0.0, 1.0);
    const double mass = double(surface.mass[pair.cell]);
    const double young = softer_of(scene.body, scene.colliders.size(), pair.other,
                                   double(surface.stiffness[pair.cell]));
    const double least = std::min(10 * young * h, scene.stiffest);
    out.point = pair.point, out.other = pair.other;
    out.stiffness = stopping(part * least, part * mass, way, scene.dt, h);
    out.at_rest = stopping(resting * least, resting * mass, 0, scene.dt, h);
    if (!(out.stiffness > 0)) return std::nullopt;
    out.size = h;
    out.normal = plane.normal;
    out.drift = plane.velocity;
    out.friction = c.friction, out.bounce = c.bounce;
    out.offset = meeting.gap - c.thickness + surface.thinner_by(pair.cell) - plane.normal.dot(p);
    return out;
}

}  // namespace

void add_stand(const PosedCollider& collider, const PlaneTouch& point, const Touch& touch,
               std::vector<CornerStand>& out)
{
    if (!std::isfinite(touch.gap)) return;
    const auto corner = std::find(point.weight.begin(), point.weight.end(), 1.0f);
    if (corner == point.weight.end()) return;
    const auto slot = point.corners[static_cast<std::size_t>(corner - point.weight.begin())];
    out.push_back(
        {slot, point.other, touch.normal, touch.gap + collider.thickness, touch.velocity});
}

void add_edge_touches(const SheetOverEdges& scene, std::vector<PlaneTouch>& out)
{
    const auto from = static_cast<std::ptrdiff_t>(out.size());
    std::vector<const CornerStand*> all;
    for (const CornerStand& stand : scene.stands) {
        if (scene.colliders[stand.other].kind != Collider::Kind::plane) all.push_back(&stand);
    }
    if (all.empty()) return;
    const auto by_collider = [](const auto* a, const auto* b) { return a->other < b->other; };
    std::stable_sort(all.begin(), all.end(), by_collider);
    const FlatCells flat = flat_cells(scene.body);
    std::vector<const CornerStand*> of(scene.body.corners, nullptr);
    for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
        while (end < all.size() && all[end]->other == all[begin]->other) ++end;
        const PosedCollider& c = scene.colliders[all[begin]->other];
        const StandsOnCollider stands(scene, std::span(all).subspan(begin, end - begin), of);
        for (const EdgePair& pair : pairs_of(scene, stands, flat)) {
            const double before = known_before * scene.body.edge_at(pair.corner[0]);
            const double thick = c.thickness - scene.body.skin.thinner_by(pair.cell);
            const auto meeting = over_edges_of(scene, stands, pair, before + thick);
            if (!meeting) continue;
            if (const auto touch = edge_touch(scene, pair, *meeting)) out.push_back(*touch);
        }
    }
    std::sort(out.begin() + from, out.end(), in_order<PlaneTouch, PlaneTouch>);
}

}  // namespace physics
