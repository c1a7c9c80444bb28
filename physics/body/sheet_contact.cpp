#include "physics/body/sheet_contact.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/body/four_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

// Map: boxes of what moves; pairs that may not touch; how four points stand to each other; planes;
// pairs of cells.

namespace physics {
namespace {

using geometry::Box3f;
using geometry::BoxTree;

constexpr std::size_t cells_a_task = 64;
constexpr double same_normal = 0.5;  // cosine

Vec3 place_at(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

// A step's view of what may touch.
struct SheetScene {
    const CornerBody& body;
    const SheetCells& cells;
    const SheetStep& step;
    const std::vector<PlaneTouch>& known;
    // Along the way that is not common to all, with half of the reach around them: of K, 2 C, all
    // edges and C.
    std::vector<Box3f> point, triangle, edge, cell;
    std::vector<Vec3> before, after;  // C, across the cells at both ends of the step
    BoxTree tree;
};

template <class Corners> Box3f box_around(const std::vector<Box3f>& points, const Corners& corners)
{
    Box3f out;
    for (const auto k : corners) out.add(points[k]);
    return out;
}

template <class Items>
void fill_boxes(const std::vector<Box3f>& points, const Items& items, std::vector<Box3f>& out)
{
    out.resize(items.size());
    geometry::parallel_for(items.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out[i] = box_around(points, items[i]);
    });
}

Vec3 across(const double* x, const std::array<std::uint32_t, 4>& cell)
{
    return (place_at(x, cell[3]) - place_at(x, cell[0]))
        .cross(place_at(x, cell[2]) - place_at(x, cell[1]));
}

// How far all corners go together, m.
Vec3 mean_way(const CornerBody& body, const SheetStep& step)
{
    Vec3 sum = Vec3::Zero();
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        sum += place_at(step.x1, k) - place_at(step.x0, k);
    }
    return sum / static_cast<double>(body.corners);
}

SheetScene scene_of(const CornerBody& body, const SheetStep& step,
                    const std::vector<PlaneTouch>& known)
{
    const SheetCells& cells = *body.sheets;
    SheetScene out{body, cells, step, known, {}, {}, {}, {}, {}, {}, {}};
    out.point.resize(body.corners);
    const Vec3 together = mean_way(body, step);
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        const Vec3 a = place_at(step.x0, k), b = place_at(step.x1, k) - together;
        // Wider by more than what single precision rounds.
        const double far = std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff());
        const Vec3 margin = Vec3::Constant(0.5 * cells.reach + 1e-6 * far);
        out.point[k].lo = (a.cwiseMin(b) - margin).cast<float>();
        out.point[k].hi = (a.cwiseMax(b) + margin).cast<float>();
    }
    fill_boxes(out.point, cells.triangle, out.triangle);
    fill_boxes(out.point, cells.edge, out.edge);
    fill_boxes(out.point, cells.cell, out.cell);
    for (const auto& corners : cells.cell) {
        out.before.push_back(across(step.x0, corners));
        out.after.push_back(across(step.x1, corners));
    }
    out.tree = fitted(cells.tree, out.cell);
    return out;
}

bool are_one_part(const CornerBody& body, std::uint32_t a, std::uint32_t b)
{
    const SheetCells& cells = *body.sheets;
    return body.part_of(cells.cell[a][0]) == body.part_of(cells.cell[b][0]);
}

// Whether two cells are so near to each other along the sheet, and so even, that they cannot meet.
bool are_one_surface(const SheetScene& scene, std::uint32_t a, std::uint32_t b)
{
    constexpr double even = 0.3;  // cosine
    if (!are_beside(scene.body, scene.cells, a, b)) return false;
    const auto alike = [&](const std::vector<Vec3>& n) {
        return n[a].dot(n[b]) > even * n[a].norm() * n[b].norm();
    };
    return alike(scene.before) && alike(scene.after);
}

// Of which cell a triangle is, or an edge: what `other` of a touch of such a point numbers.
std::uint32_t cell_of(const CornerBody& body, std::uint32_t point, std::uint32_t other)
{
    if (point - body.sheets->first_number < body.corners) return other / 2;
    const auto& first = body.sheets->edge_at;
    const auto next = std::upper_bound(first.begin(), first.end(), other);
    return static_cast<std::uint32_t>(next - first.begin()) - 1;
}

// The deepest grip of a point on cells beside the one of `other` that pass a test; null: none.
template <class Test>
const Grip* deepest_beside(const CornerBody& body, const std::vector<Grip>& grips,
                           std::uint32_t point, std::uint32_t other, const Test& passes)
{
    const std::uint32_t cell = cell_of(body, point, other);
    const auto before = [](const Grip& grip, std::uint32_t p) { return grip.point < p; };
    const Grip* out = nullptr;
    for (auto grip = std::lower_bound(grips.begin(), grips.end(), point, before);
         grip != grips.end() && grip->point == point; ++grip) {
        if (out && !(grip->depth > out->depth)) continue;
        if (passes(*grip, cell_of(body, point, grip->other), cell)) out = &*grip;
    }
    return out;
}

double segment_distance_sq(const Vec3& p, const Vec3& a, const Vec3& b)
{
    const Vec3 side = b - a;
    const double share = std::clamp((p - a).dot(side) / side.squaredNorm(), 0.0, 1.0);
    return (p - a - share * side).squaredNorm();
}

// What may meet: a point and a triangle, or two edges, and their numbers as a touch has them.
struct MayMeet {
    Four kind;
    std::array<std::uint32_t, 4> corner;
    std::uint32_t point, other;
    bool one;  // they are of one part
};

// Whether they lie within `far` (m) at rest.
bool are_near_at_rest(const SheetScene& scene, const MayMeet& pair, double far)
{
    FourPoints x;
    for (std::size_t i = 0; i < 4; ++i) x[i] = place_at(scene.body.rest.data(), pair.corner[i]);
    const auto stand = stand_of(pair.kind, x);
    if (stand && std::abs(stand->distance) < far) return true;
    double least_sq =
        std::min(segment_distance_sq(x[0], x[1], x[2]), segment_distance_sq(x[0], x[2], x[3]));
    if (pair.kind == Four::point) {
        least_sq = std::min(least_sq, segment_distance_sq(x[0], x[3], x[1]));
    } else {
        least_sq = std::min(
            {segment_distance_sq(x[0], x[2], x[3]), segment_distance_sq(x[1], x[2], x[3]),
             segment_distance_sq(x[2], x[0], x[1]), segment_distance_sq(x[3], x[0], x[1])});
    }
    return least_sq < far * far;
}

bool is_known(const SheetScene& scene, const MayMeet& pair)
{
    const auto found = std::lower_bound(scene.known.begin(), scene.known.end(), pair,
                                        in_order<PlaneTouch, MayMeet>);
    return found != scene.known.end() && !in_order(pair, *found);
}

// Where its point has slid from. That of an edge does not tell the side: where edges cross other
// ones, their normals turn about.
const Grip* grip_beside(const SheetScene& scene, const MayMeet& pair)
{
    return deepest_beside(scene.body, scene.step.grips, pair.point, pair.other,
                          [&](const Grip&, std::uint32_t a, std::uint32_t b) {
                              return are_one_surface(scene, a, b);
                          });
}

// How they stand, with the normal out of the side that is to be kept.
std::optional<Stand> kept_apart(const SheetScene& scene, const MayMeet& pair)
{
    FourPoints a, b;
    for (std::size_t i = 0; i < 4; ++i) {
        a[i] = place_at(scene.step.x0, pair.corner[i]);
        b[i] = place_at(scene.step.x1, pair.corner[i]);
    }
    const auto beside = [&] {
        return pair.kind == Four::point ? grip_beside(scene, pair) : nullptr;
    };
    const auto own = [](const Stand& stand) {
        return turned_to(stand, stand.distance * stand.normal);
    };
    return side_to_keep(pair.kind, a, b, scene.cells.reach,
                        find_grip(scene.step.grips, pair.point, pair.other), beside, own);
}

// Its corners, the first eight of the point or the first edge.
void set_corners(const MayMeet& pair, const Stand& stand, PlaneTouch& touch)
{
    const std::size_t first = pair.kind == Four::point ? 1 : 2;
    touch.count = 12;
    touch.corners.fill(pair.corner[0]);
    std::fill(touch.corners.begin() + 8, touch.corners.end(), pair.corner[first]);
    for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t to = i < first ? i : 8 + i - first;
        touch.corners[to] = pair.corner[i];
        touch.weight[to] = static_cast<float>(stand.weight[i]);
    }
}

void meet(const SheetScene& scene, const MayMeet& pair, std::vector<PlaneTouch>& out)
{
    const auto& k = pair.corner;
    const std::size_t first = pair.kind == Four::point ? 1 : 2;
    for (std::size_t i = 0; i < first; ++i) {
        if (std::find(k.begin() + std::ptrdiff_t(first), k.end(), k[i]) != k.end()) return;
    }
    if (is_known(scene, pair)) return;
    const auto stand = kept_apart(scene, pair);
    if (!stand) return;
    double thickness = 0, stiffness = 0, mass = 0, way = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const double w = stand->weight[i], share = 0.5 * std::abs(w);
        thickness += share * double(scene.cells.thickness[k[i]]);
        stiffness += share * double(scene.cells.stiffness[k[i]]);
        mass += share * scene.body.mass[k[i]];
        way -= w * stand->normal.dot(place_at(scene.step.x1, k[i]) - place_at(scene.step.x0, k[i]));
    }
    if (stand->distance > scene.cells.reach) return;
    if (pair.one && are_near_at_rest(scene, pair, 2 * thickness)) return;
    PlaneTouch& touch = out.emplace_back();
    set_corners(pair, *stand, touch);
    touch.point = pair.point, touch.other = pair.other;
    touch.normal = stand->normal;
    touch.offset = -thickness;
    touch.size = thickness;
    touch.stiffness = stopping(stiffness, mass, way, scene.step.dt, thickness);
    touch.at_rest = stopping(stiffness, mass, 0, scene.step.dt, thickness);
    touch.friction = scene.cells.friction;
    touch.bounce = scene.cells.bounce;
}

void meet_points(const SheetScene& scene, std::uint32_t a, std::uint32_t b,
                 std::vector<PlaneTouch>& out)
{
    const SheetCells& cells = scene.cells;
    const std::uint32_t first = cells.first_number;
    const bool one = are_one_part(scene.body, a, b);
    for (auto i = cells.point_at[a]; i < cells.point_at[a + 1]; ++i) {
        const std::uint32_t p = cells.point[i];
        if (!scene.point[p].overlaps(scene.cell[b])) continue;
        for (const auto t : {2 * b, 2 * b + 1}) {
            if (!scene.point[p].overlaps(scene.triangle[t])) continue;
            const auto& k = cells.triangle[t];
            if (k[1] == k[2]) continue;  // a cell of one triangle
            meet(scene, {Four::point, {p, k[0], k[1], k[2]}, first + p, t, one}, out);
        }
    }
}

void meet_edges(const SheetScene& scene, std::uint32_t a, std::uint32_t b,
                std::vector<PlaneTouch>& out)
{
    const SheetCells& cells = scene.cells;
    const bool one = are_one_part(scene.body, a, b);
    const auto first = cells.first_number + static_cast<std::uint32_t>(scene.body.corners);
    for (auto i = cells.edge_at[a]; i < cells.edge_at[a + 1]; ++i) {
        if (!scene.edge[i].overlaps(scene.cell[b])) continue;
        for (auto j = cells.edge_at[b]; j < cells.edge_at[b + 1]; ++j) {
            if (!scene.edge[i].overlaps(scene.edge[j])) continue;
            const auto &k = cells.edge[i], &l = cells.edge[j];
            meet(scene, {Four::edges, {k[0], k[1], l[0], l[1]}, first + i, j, one}, out);
        }
    }
}

}  // namespace

bool are_beside(const CornerBody& body, const SheetCells& cells, std::uint32_t a, std::uint32_t b)
{
    constexpr int near = 2;
    if (body.part_of(cells.cell[a][0]) != body.part_of(cells.cell[b][0])) return false;
    if (!cells.beside_at.empty()) {
        const auto first = cells.beside.begin();
        return std::binary_search(first + cells.beside_at[a], first + cells.beside_at[a + 1], b);
    }
    const auto& place = cells.place;
    return (place[a] - place[b]).cwiseAbs().maxCoeff() <= near;
}

BoxTree fitted(const BoxTree& tree, const std::vector<Box3f>& boxes)
{
    BoxTree out = tree;
    for (std::size_t n = out.nodes.size(); n-- > 0;) {
        BoxTree::Node& node = out.nodes[n];
        node.box = {};
        for (std::uint32_t i = 0; i < node.count; ++i) {
            node.box.add(boxes[out.items[node.first + i]]);
        }
        if (node.count > 0) continue;
        node.box.add(out.nodes[node.first].box);
        node.box.add(out.nodes[node.first + 1].box);
    }
    return out;
}

const Grip* grip_beside(const CornerBody& body, const std::vector<Grip>& grips,
                        const PlaneTouch& touch)
{
    return deepest_beside(body, grips, touch.point, touch.other,
                          [&](const Grip& grip, std::uint32_t a, std::uint32_t b) {
                              return are_beside(body, *body.sheets, a, b) &&
                                     grip.normal.cast<double>().dot(touch.normal) > same_normal;
                          });
}

std::vector<PlaneTouch> find_sheet_touches(const CornerBody& body, const SheetStep& step,
                                           const std::vector<PlaneTouch>& known)
{
    const SheetScene scene = scene_of(body, step, known);
    const SheetCells& cells = scene.cells;
    const std::size_t count = cells.cell.size();
    std::vector<std::vector<PlaneTouch>> found((count + cells_a_task - 1) / cells_a_task);
    const auto search = [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> near;
        for (std::size_t g = begin; g < end; ++g) {
            const std::size_t last = std::min(count, (g + 1) * cells_a_task);
            for (auto a = static_cast<std::uint32_t>(g * cells_a_task); a < last; ++a) {
                near.clear();
                scene.tree.overlapping(scene.cell[a], [&](std::uint32_t b) {
                    const bool apart = cells.self || cells.model[a] != cells.model[b];
                    if (b > a && apart && scene.cell[a].overlaps(scene.cell[b])) near.push_back(b);
                });
                for (const auto b : near) {
                    if (are_one_surface(scene, a, b)) continue;
                    meet_points(scene, a, b, found[g]);
                    meet_points(scene, b, a, found[g]);
                    meet_edges(scene, a, b, found[g]);
                }
            }
        }
    };
    geometry::parallel_for(found.size(), 1, search);
    return put_in_order(found);
}

}  // namespace physics
