#include "physics/body/part_contact.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/body/bent_cube.hpp"
#include "physics/body/box_regions.hpp"
#include "physics/body/near_cubes.hpp"
#include "physics/body/points_now.hpp"

#include <algorithm>
#include <cmath>

// Map: the plane of a point; the touches of some points; where parts meet; pairs that are near.

namespace physics {
namespace {

using geometry::Box;
using geometry::Mat3;

Vec3 corner_of(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

// With where it was before it went `way`.
Box swept(Box box, const Vec3& way)
{
    const Box now = box;
    box.add(Vec3(now.lo - way));
    box.add(Vec3(now.hi - way));
    return box;
}

// A step's view of what may touch.
struct Scene : StepOfParts {
    double stiffest;  // N/m
    const std::vector<PlaneTouch>& known;
    std::vector<std::uint32_t> known_at;  // into known, of each point and the end
    PointsNow now;
};

// Points of part `from` that may be in part `target`, an index into targets.
struct Job {
    std::uint32_t from = 0, target = 0;
    std::size_t begin = 0, end = 0;  // of its cubes with points
};

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

// The plane of a point where it meets the target.
PlaneTouch make_touch(const Scene& scene, const Moving& moving, const Target& target,
                      const PartMeeting& met)
{
    const auto& [cube, in, gap] = met;
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
            const Arriving arriving{moving.p, moving.v, on_itself, 0,
                                    [&] { return outward_of(scene, moving); }};
            if (const auto met = first_meeting(scene, arriving, target, near, close)) {
                out.push_back(make_touch(scene, moving, target, *met));
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
    std::vector<std::uint32_t> number_of(shapes.parts(), geometry::no_index);
    const auto target = [&](std::uint32_t part) {
        if (number_of[part] == geometry::no_index) {
            number_of[part] = static_cast<std::uint32_t>(out.targets.size());
            out.targets.push_back(target_of(scene, part));
        }
        return number_of[part];
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
    const Scene scene{{shapes, x, v, dt, how},
                      stiffest,
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
