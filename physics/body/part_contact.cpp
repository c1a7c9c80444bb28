#include "physics/body/part_contact.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/body/bent_cube.hpp"
#include "physics/body/box_regions.hpp"
#include "physics/body/near_cubes.hpp"
#include "physics/body/part_gap.hpp"
#include "physics/body/places_on_way.hpp"
#include "physics/body/points_now.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

// Map: boxes of parts, and the pairs that are near; the cubes of a part that may be touched; the
// touches of some points.

namespace physics {
namespace {

using geometry::Box;
using geometry::Box3f;
using geometry::BoxTree;
using geometry::Mat3;
using geometry::Vec3f;

Vec3 corner_of(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

Box wider(Box box, double by)
{
    box.lo.array() -= by;
    box.hi.array() += by;
    return box;
}

// With where it was before it went `way`.
Box swept(Box box, const Vec3& way)
{
    const Box now = box;
    box.add(Vec3(now.lo - way));
    box.add(Vec3(now.hi - way));
    return box;
}

Box box_of(const double* x, const std::array<std::uint32_t, 8>& corners)
{
    Box box;
    for (const auto k : corners) box.add(corner_of(x, k));
    return box;
}

// A step's view of what may touch.
struct Scene {
    const PartShapes& shapes;
    const double* x;
    const double* v;
    double dt;
    double stiffest;  // N/m
    Look look;
    const std::vector<PlaneTouch>& known;
    std::vector<std::uint32_t> known_at;  // into known, of each point and the end
    PointsNow now;
};

// The cubes of a part that lie where another one may be, at x.
struct Target {
    std::uint32_t part = 0;
    Vec3 velocity = Vec3::Zero();  // m/s, the mean of its corners
    Box box;                       // of all of its corners
    std::vector<std::uint32_t> cubes;
    std::vector<Box3f> boxes;  // of each, with room around it
    BoxTree tree;
};

// Points of part `from` that may be in part `target`, an index into targets.
struct Job {
    std::uint32_t from = 0, target = 0;
    std::size_t begin = 0, end = 0;  // of its cubes with points
};

void fill_target(const Scene& scene, const std::vector<Box>& regions, Target& target)
{
    const BoxRegions near(regions);
    for (const auto c : scene.shapes.cubes[target.part]) {
        const Box box = box_of(scene.x, scene.shapes.corners[c]);
        if (!near.meet(box)) continue;
        // Wider by more than what single precision rounds.
        const double far = box.lo.cwiseAbs().cwiseMax(box.hi.cwiseAbs()).maxCoeff();
        const Box margin = wider(box, 1e-3 * scene.shapes.size_of(target.part) + 1e-6 * far);
        const Box3f wide{margin.lo.cast<float>(), margin.hi.cast<float>()};
        if (!wide.lo.allFinite() || !wide.hi.allFinite()) continue;
        target.cubes.push_back(c);
        target.boxes.push_back(wide);
    }
    target.tree = geometry::build_box_tree(target.boxes);
}

// A point of a part's shape on its way.
struct Moving {
    std::uint32_t part = 0;
    std::uint32_t cube = 0, number = 0;  // of the point
    const ShapePoint* point = nullptr;
    Vec3 p = Vec3::Zero(), v = Vec3::Zero();  // m, m/s
};

// The unit vector out of the matter that the point is on.
Vec3 outward_of(const Scene& scene, const Moving& moving)
{
    std::array<Vec3, 8> x;
    for (std::size_t a = 0; a < 8; ++a) {
        x[a] = corner_of(scene.x, scene.shapes.corners[moving.cube][a]);
    }
    Vec3 p;
    const Mat3 axes = place_in(x, moving.point->place.cast<double>(), p).axes;
    if (!(std::abs(axes.determinant()) > 0)) return Vec3::Zero();
    return (axes.inverse().transpose() * moving.point->normal.cast<double>()).normalized();
}

// The plane at a gap that a point has where it is `in` a cube of the target.
PlaneTouch make_touch(const Scene& scene, const Moving& moving, const Target& target,
                      std::uint32_t cube, const InCube& in, const Gap& gap)
{
    const PartShapes& shapes = scene.shapes;
    const double from = shapes.size_of(moving.part), area = double(moving.point->area);
    const double h = std::min(from, shapes.size_of(target.part));
    const double young = std::min(shapes.stiffness[moving.cube], shapes.stiffness[cube]);
    const double mass = std::min(shapes.mass[moving.cube] * std::min(1.0, area / (from * from)),
                                 double(shapes.mass[cube]));
    PlaneTouch touch;
    touch.point = moving.number;
    touch.other = target.part;
    touch.normal = gap.normal;
    touch.size = h;
    touch.friction = shapes.friction;
    touch.bounce = shapes.bounce;
    const double way = scene.dt * (target.velocity - moving.v).dot(gap.normal);
    const double least = std::min(10 * young * area / h, scene.stiffest);
    touch.stiffness = stopping(least, mass, way, scene.dt, h);
    touch.at_rest = stopping(least, mass, 0, scene.dt, h);
    const std::array<double, 8> own =
        geometry::trilinear_weights(moving.point->place.cast<double>());
    const std::array<double, 8> weight = geometry::trilinear_weights(in.u);
    for (std::size_t a = 0; a < 8; ++a) {
        touch.corners[a] = shapes.corners[moving.cube][a];
        touch.weight[a] = static_cast<float>(own[a]);
        touch.corners[8 + a] = shapes.corners[cube][a];
        touch.weight[8 + a] = -static_cast<float>(weight[a]);
    }
    touch.offset = gap.size - touch.gap(scene.x);
    return touch;
}

std::array<Vec3, 8> corners_of(const Scene& scene, std::uint32_t cube)
{
    std::array<Vec3, 8> x;
    for (std::size_t a = 0; a < 8; ++a) x[a] = corner_of(scene.x, scene.shapes.corners[cube][a]);
    return x;
}

// Where a point would be in a cube of the target when it is `behind` (m) where it is.
std::optional<PlaneTouch> touch_in(const Scene& scene, const Moving& moving, const Target& target,
                                   std::uint32_t cube, const Vec3& behind)
{
    constexpr double slack = 1e-6;     // cubes: what lies on a face is in both cubes
    constexpr double rounding = 1e-6;  // cubes: of what lies no deeper, the side is not known
    const PartShapes& shapes = scene.shapes;
    const double size = shapes.size_of(target.part);
    const auto in = find_in_cube(corners_of(scene, cube), size, moving.p - behind, slack);
    if (!in) return std::nullopt;
    const std::array<double, 8> weight = geometry::trilinear_weights(in->u);
    Vec3 velocity = moving.v;  // relative to the matter there
    for (std::size_t a = 0; a < 8; ++a) {
        velocity -= weight[a] * corner_of(scene.v, shapes.corners[cube][a]);
    }
    // How it got to where a step begins is not known.
    const Vec3 way =
        scene.look == Look::ahead ? Vec3(Vec3::Zero()) : Vec3(scene.dt * velocity - behind);
    auto gap = find_gap({shapes, target.part, cube, *in},
                        {way, outward_of(scene, moving), moving.part == target.part});
    if (!gap) return std::nullopt;
    gap->size += behind.dot(gap->normal);
    if (!(gap->size < -rounding * size)) return std::nullopt;
    return make_touch(scene, moving, target, cube, *in, *gap);
}

// How far before a face a point may be to be told of it, cubes of size `h`: more where it looks
// ahead at speed.
constexpr double most_ahead = 1;
double reach_of(const Scene& scene, double way, double h)
{
    if (scene.look == Look::back) return known_before;
    return std::min(known_before + way / h, most_ahead);
}

// How far ahead a point that goes `way` (m) is looked for.
Vec3 way_ahead(const Vec3& way, double h)
{
    const double most = (most_ahead - known_before) * h;
    return way * std::min(1.0, most / std::max(most, way.norm()));
}

// The plane before a point that is in none of the target's cubes `near`: of the one that it is
// nearest to, among three whose middles are.
std::optional<PlaneTouch> touch_before(const Scene& scene, const Moving& moving,
                                       const Target& target, const std::vector<NearCube>& near,
                                       double reach)
{
    const double h = scene.shapes.size_of(target.part);
    const Vec3f p = moving.p.cast<float>();
    constexpr std::size_t tried = 3;
    std::array<std::pair<float, std::uint32_t>, tried> nearest;
    nearest.fill({std::numeric_limits<float>::infinity(), 0});
    for (std::uint32_t i = 0; i < near.size(); ++i) {
        const Box3f& box = near[i].box;
        const std::pair<float, std::uint32_t> here{(0.5f * (box.lo + box.hi) - p).squaredNorm(), i};
        if (!(here < nearest.back())) continue;
        nearest.back() = here;
        std::sort(nearest.begin(), nearest.end());
    }
    std::optional<InCube> best;
    std::uint32_t cube = 0;
    double least = reach;
    for (const auto& [distance, at] : nearest) {
        if (!std::isfinite(distance)) break;
        const auto& [box, c] = near[at];
        // It is no further from the cube than that many of the cube's edges.
        const double most = least * double((box.hi - box.lo).norm());
        if (box.distance_sq(moving.p) > most * most) continue;
        const auto in = find_in_cube(corners_of(scene, c), h, moving.p, least);
        if (!in) continue;
        const double off = std::max({0.0, -in->u.minCoeff(), in->u.maxCoeff() - 1});
        if (best && off >= least) continue;
        best = in, cube = c, least = off;
    }
    if (!best) return std::nullopt;
    const AtRest rest{scene.shapes, target.part, cube, *best};
    const bool own = moving.part == target.part;
    const auto gap = find_distance(rest, outward_of(scene, moving), reach * h, own);
    if (!gap) return std::nullopt;
    return make_touch(scene, moving, target, cube, *best, *gap);
}

// The touch of a point with one of the target's cubes `near`, at the first place on its way where
// it is inside; else of where it is before them. `close` is room.
std::optional<PlaneTouch> first_touch(const Scene& scene, const Moving& moving,
                                      const Target& target, NearCubes& near,
                                      std::vector<NearCube>& close)
{
    constexpr double stride = 0.4;  // of a cube
    constexpr int most = 64;        // places on a short way
    const Vec3 way = scene.dt * (moving.v - target.velocity);
    const double h = scene.shapes.size_of(target.part);
    const double strides = std::ceil(way.norm() / (stride * h));
    if (!std::isfinite(strides)) return std::nullopt;
    const int places = std::clamp(static_cast<int>(std::min(strides, double(most))), 1, most);
    const int first = scene.look == Look::ahead ? places : 1;
    const double reach = reach_of(scene, way.norm(), h);
    Box about;
    about.add(moving.p);
    about.add(scene.look == Look::back ? Vec3(moving.p - way) : moving.p + way_ahead(way, h));
    about = wider(about, known_before * h);
    const Box3f span{about.lo.cast<float>(), about.hi.cast<float>()};
    near.meeting(span, close);
    if (close.empty()) return std::nullopt;
    Places look{double(first), double(places), 1, double(places)};
    if (first == 1 && strides > most) {
        Box3f all;
        for (const auto& [box, cube] : close) all.add(box);
        look = places_within(all, moving.p, way, strides);
    }
    for (double place = look.from; place <= look.to; place += look.step) {
        const Vec3 behind = (1 - place / look.of) * way;
        const Vec3f p = (moving.p - behind).cast<float>();
        for (const auto& [box, cube] : close) {
            if (!box.overlaps({p, p})) continue;
            if (auto touch = touch_in(scene, moving, target, cube, behind)) return touch;
        }
    }
    return touch_before(scene, moving, target, close, reach);
}

// Takes the target's cubes among `others`, ascending, out of `near`, ascending.
void leave_out(const Target& target, std::span<const std::uint32_t> others,
               std::vector<std::uint32_t>& near)
{
    auto other = others.begin();
    std::erase_if(near, [&](std::uint32_t i) {
        while (other != others.end() && *other < target.cubes[i]) ++other;
        return other != others.end() && *other == target.cubes[i];
    });
}

// Where a cube's points may meet the target's cubes.
Box reach_of(const Scene& scene, const HolderNow& now, const Target& target)
{
    constexpr double rounding = 1e-6;  // cubes
    const double h = scene.shapes.size_of(target.part);
    const Vec3 way = scene.dt * (now.velocity - target.velocity);
    const double spread = scene.dt * now.spread;
    const Vec3 before = scene.look == Look::back ? way : Vec3(-way_ahead(way, h));
    return wider(swept(now.box, before), spread + (known_before + rounding) * h);
}

// The points begin .. end that are not known to touch a part.
void find_unknown(const Scene& scene, std::uint32_t part, std::uint32_t begin, std::uint32_t end,
                  std::vector<std::uint32_t>& out)
{
    out.clear();
    for (std::uint32_t p = begin; p < end; ++p) {
        bool knows = false;
        for (auto i = scene.known_at[p]; i < scene.known_at[p + 1]; ++i) {
            knows |= scene.known[i].other == part;
        }
        if (!knows) out.push_back(p);
    }
}

void look(const Scene& scene, const Job& job, const Target& target, std::vector<PlaneTouch>& out)
{
    const PartShapes& shapes = scene.shapes;
    const auto holders = shapes.holders[job.from];
    const bool on_itself = job.from == target.part;
    std::vector<std::uint32_t> found;  // of the target's cubes
    NearCubes near;
    std::vector<NearCube> close;
    std::vector<std::uint32_t> unknown;
    for (std::size_t i = job.begin; i < job.end; ++i) {
        geometry::stop_if_asked();
        const std::uint32_t holder = holders[i], cube = shapes.holder[holder];
        const Box reach = reach_of(scene, scene.now.holder[holder], target);
        if (!overlap(reach, target.box)) continue;
        find_unknown(scene, target.part, shapes.point_at[holder], shapes.point_at[holder + 1],
                     unknown);
        if (unknown.empty()) continue;
        found.clear();
        target.tree.overlapping({reach.lo.cast<float>(), reach.hi.cast<float>()},
                                [&](std::uint32_t c) { found.push_back(c); });
        if (found.empty()) continue;
        std::sort(found.begin(), found.end());
        if (on_itself) leave_out(target, shapes.around[holder], found);
        near.clear();
        for (const auto c : found) near.add({target.boxes[c], target.cubes[c]});
        if (near.empty()) continue;
        for (const auto p : unknown) {
            const Moving moving{
                job.from, cube, p, &shapes.point[p], scene.now.point[p].p, scene.now.point[p].v};
            if (const auto touch = first_touch(scene, moving, target, near, close)) {
                out.push_back(*touch);
            }
        }
    }
}

// Where the boxes of parts overlap now: the regions of each part's cubes, and who looks into whom.
struct Meetings {
    std::vector<Target> targets;
    std::vector<std::vector<Box>> regions;  // of each target
    std::vector<Job> jobs;
};

// Points of part `from` in the target number `into`.
void add_jobs(const PartShapes& shapes, std::uint32_t from, std::uint32_t into,
              std::vector<Job>& jobs)
{
    constexpr std::size_t grain = 64;  // cubes with points
    const std::size_t holders = shapes.holders[from].size();
    for (std::size_t i = 0; i < holders; i += grain) {
        jobs.push_back({from, into, i, std::min(holders, i + grain)});
    }
}

Meetings find_meetings(const Scene& scene, const std::vector<PartPair>& pairs)
{
    const PartShapes& shapes = scene.shapes;
    Meetings out;
    std::vector<std::uint32_t> target_of(shapes.parts(), geometry::no_index);
    const auto target = [&](std::uint32_t part) {
        if (target_of[part] == geometry::no_index) {
            target_of[part] = static_cast<std::uint32_t>(out.targets.size());
            out.targets.push_back({part, Vec3::Zero(), {}, {}, {}, {}});
            Box& box = out.targets.back().box;
            auto& velocity = out.targets.back().velocity;
            for (const auto slot : shapes.slots[part]) {
                box.add(corner_of(scene.x, slot));
                velocity += corner_of(scene.v, slot);
            }
            velocity /= static_cast<double>(shapes.slots[part].size());
        }
        return target_of[part];
    };
    for (const auto& pair : pairs) target(pair.a), target(pair.b);
    out.regions.resize(out.targets.size());
    for (const auto& pair : pairs) {
        const auto a = target(pair.a), b = target(pair.b);
        // Points may lie outside of their cubes, and may have passed through the other part.
        const double margin = std::max(shapes.size_of(pair.a), shapes.size_of(pair.b));
        const Vec3 way = scene.dt * (out.targets[a].velocity - out.targets[b].velocity);
        const Box box_a = swept(wider(out.targets[a].box, margin), way);
        const Box box_b = swept(wider(out.targets[b].box, margin), -way);
        const Box region{box_a.lo.cwiseMax(box_b.lo), box_a.hi.cwiseMin(box_b.hi)};
        if (region.empty()) continue;
        out.regions[a].push_back(region);
        out.regions[b].push_back(region);
        add_jobs(shapes, pair.a, b, out.jobs);
        if (pair.a != pair.b) add_jobs(shapes, pair.b, a, out.jobs);
    }
    return out;
}

}  // namespace

std::vector<PartPair> near_parts(const PartShapes& shapes, const double* x, const double* v,
                                 double dt)
{
    const std::size_t parts = shapes.parts();
    std::vector<Box> box(parts);
    for (std::size_t p = 0; p < parts; ++p) {
        for (const auto slot : shapes.slots[p]) {
            box[p].add(corner_of(x, slot));
            box[p].add(Vec3(corner_of(x, slot) + dt * corner_of(v, slot)));
        }
        box[p] = wider(box[p], shapes.size_of(static_cast<std::uint32_t>(p)));
    }
    std::vector<std::uint32_t> order(parts);
    for (std::uint32_t p = 0; p < parts; ++p) order[p] = p;
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return box[a].lo.x() < box[b].lo.x();
    });
    std::vector<PartPair> pairs;
    for (std::size_t i = 0; i < parts; ++i) {
        for (std::size_t j = i + 1; j < parts; ++j) {
            if (box[order[j]].lo.x() > box[order[i]].hi.x()) break;
            if (!overlap(box[order[i]], box[order[j]])) continue;
            const PartPair pair{std::min(order[i], order[j]), std::max(order[i], order[j])};
            if (!std::binary_search(shapes.overlapping.begin(), shapes.overlapping.end(), pair)) {
                pairs.push_back(pair);
            }
        }
    }
    for (std::uint32_t p = 0; shapes.touch_themselves() && p < parts; ++p) pairs.push_back({p, p});
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

std::vector<PlaneTouch> find_part_touches(const PartShapes& shapes,
                                          const std::vector<PartPair>& pairs, const double* x,
                                          const double* v, double dt, Look how,
                                          const std::vector<PlaneTouch>& known)
{
    if (pairs.empty()) return {};
    const double stiffest = 1000 * shapes.mass_of_all * 9.81 / shapes.least_size;
    const Scene scene{shapes,
                      x,
                      v,
                      dt,
                      stiffest,
                      how,
                      known,
                      first_of_points(known, shapes.point.size()),
                      points_now(shapes, pairs, x, v)};
    Meetings meetings = find_meetings(scene, pairs);
    geometry::parallel_for(meetings.targets.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            if (meetings.regions[t].empty()) continue;
            geometry::stop_if_asked();
            fill_target(scene, meetings.regions[t], meetings.targets[t]);
        }
    });
    std::vector<std::vector<PlaneTouch>> found(meetings.jobs.size());
    geometry::parallel_for(meetings.jobs.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) {
            const Job& job = meetings.jobs[j];
            const Target& target = meetings.targets[job.target];
            look(scene, job, target, found[j]);
        }
    });
    return put_in_order(found);
}

}  // namespace physics
