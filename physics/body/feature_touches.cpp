#include "physics/body/feature_touches.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "physics/body/box_regions.hpp"
#include "physics/body/collider_features.hpp"
#include "physics/body/meet_part.hpp"
#include "physics/body/shapes_on_demand.hpp"
#include "physics/body/sheet_edges.hpp"
#include "physics/body/solids_beside_sheets.hpp"

#include <algorithm>
#include <cmath>

// Map: which parts are near which colliders; the plane of a point; what points meet.

namespace physics {
namespace {

using geometry::Box;
using geometry::Box3f;

constexpr std::uint32_t first_feature = 1u << 31;  // the number of a touch

// A part of the body on its way.
struct PartOnWay {
    Box box;           // m, of its corners
    double speed = 0;  // m/s, of the fastest
};

std::vector<PartOnWay> parts_on_way(const SolidsOverEdges& scene)
{
    std::vector<PartOnWay> out(scene.body.outlines->parts());
    for (std::uint32_t k = 0; k < scene.body.corners; ++k) {
        const auto part = scene.body.part_of(k);
        if (part >= out.size()) continue;  // of a sheet
        out[part].box.add(corner_place(scene.x, k));
        out[part].speed = std::max(out[part].speed, corner_place(scene.v, k).norm());
    }
    return out;
}

// The points of a collider that may meet a part.
struct NearPart {
    std::uint32_t part = 0, other = 0;
    std::uint32_t size = 0;  // number of the edge of its cubes among those of all parts
    double around = 0;       // m, that the collider begins before its surface
    Box region;
    std::vector<FeaturePoint> points;
};

// m/s, of the fastest place of a collider in a box.
double fastest_in(const PosedCollider& c, const Box& box)
{
    if (c.mesh_before) return c.frame > 0 ? c.longest / c.frame : 0;
    const Vec3 arm = (box.lo - c.pose.translation())
                         .cwiseAbs()
                         .cwiseMax((box.hi - c.pose.translation()).cwiseAbs());
    return c.slides.norm() + c.turns.norm() * arm.norm();
}

// The edges of the cubes of parts, each once, from the smallest, m.
std::vector<double> sizes_of(const CornerBody& body, std::size_t parts)
{
    if (body.part_edge.empty()) return {body.h};
    std::vector<double> out(body.part_edge.begin(),
                            body.part_edge.begin() + static_cast<std::ptrdiff_t>(parts));
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

std::vector<NearPart> near_parts_of(const SolidsOverEdges& scene)
{
    std::vector<NearPart> out;
    const CornerBody& body = scene.body;
    const std::size_t solids = body.solids ? body.solids->solid.size() : 0;
    std::vector<Box> bounds;
    for (std::size_t i = 0; i + solids < scene.colliders.size(); ++i) {
        bounds.push_back(bounds_of_features(scene.colliders[i], body.greatest_edge));
    }
    const auto is_empty = [](const Box& box) { return box.empty(); };
    if (std::all_of(bounds.begin(), bounds.end(), is_empty)) return out;
    const std::vector<PartOnWay> parts = parts_on_way(scene);
    const std::vector<double> sizes = sizes_of(body, parts.size());
    for (std::uint32_t p = 0; p < parts.size(); ++p) {
        const double edge = body.part_edge.empty() ? body.h : body.part_edge[p];
        const auto size = static_cast<std::uint32_t>(
            std::lower_bound(sizes.begin(), sizes.end(), edge) - sizes.begin());
        for (std::uint32_t i = 0; i < bounds.size(); ++i) {
            if (parts[p].box.empty() || bounds[i].empty()) continue;
            const PosedCollider& c = scene.colliders[i];
            const double around = c.thickness - body.skin.thickest;
            const double round = c.kind == Collider::Kind::sphere ? c.radius : 0;
            const double reach = known_before * edge + around + round;
            // Points of the shape may lie outside of the cubes.
            const double way = scene.dt * (parts[p].speed + fastest_in(c, parts[p].box));
            const Box region = wider(parts[p].box, edge + reach + way);
            if (!overlap(region, bounds[i])) continue;
            auto points = features_in(c, region, edge);
            if (!points.empty()) out.push_back({p, i, size, around, region, std::move(points)});
        }
    }
    return out;
}

// Points of a collider are numbered anew for cubes of another size. Two of the same number at a
// time are as good as never.
std::uint32_t number_of(const FeaturePoint& point, std::uint32_t size)
{
    return first_feature + ((point.number + size * 0x9E3779B1u) & (first_feature - 1));
}

// The plane of the place where a point meets a part, with a number that is its own.
PlaneTouch make_touch(const SolidsOverEdges& scene, const StepOfParts& step, const NearPart& near,
                      const FeaturePoint& point, const PartMeeting& met)
{
    constexpr double area = 0.25;  // squared cubes
    const PartShapes& shapes = step.shapes;
    const PosedCollider& collider = scene.colliders[near.other];
    const double h = shapes.size_of(near.part);
    PlaneTouch out;
    out.count = 8;
    out.point = number_of(point, near.size);
    out.other = near.other;
    out.size = h;
    out.normal = -met.gap.normal;
    out.friction = collider.friction;
    out.bounce = collider.bounce;
    const std::array<double, 8> weight = geometry::trilinear_weights(met.in.u);
    Vec3 velocity = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        out.corners[a] = shapes.corners[met.cube][a];
        out.weight[a] = static_cast<float>(weight[a]);
        velocity += double(out.weight[a]) * corner_place(scene.v, out.corners[a]);
    }
    const Vec3 place = point.place + point.radius * out.normal;
    Touch t = touch(collider, place);
    turn_touch(collider, out.normal, t);
    out.drift = carrying(collider, t, place, t.velocity, scene.dt);
    const double way = scene.dt * (t.velocity - velocity).dot(out.normal);
    const double least =
        std::min(10 * double(shapes.stiffness[met.cube]) * area * h, scene.stiffest);
    const double mass = area * double(shapes.mass[met.cube]);
    out.stiffness = stopping(least, mass, way, scene.dt, h);
    out.at_rest = stopping(least, mass, 0, scene.dt, h);
    out.offset = met.gap.size - point.radius - near.around - out.gap(scene.x);
    return out;
}

void meet(const SolidsOverEdges& scene, const StepOfParts& step, const NearPart& near,
          std::vector<PlaneTouch>& out)
{
    const PosedCollider& collider = scene.colliders[near.other];
    const double h = step.shapes.size_of(near.part);
    Target target = target_of(step, near.part);
    fill_target(step, {near.region}, target);
    NearCubes cubes;
    std::vector<NearCube> close;
    std::vector<std::uint32_t> found;
    for (const FeaturePoint& point : near.points) {
        const Vec3 velocity = touch(collider, point.place).velocity;
        const double around = point.radius + near.around;
        Box box;
        box.add(point.place);
        box.add(Vec3(point.place - scene.dt * (velocity - target.velocity)));
        box = wider(box, known_before * h + around);
        found.clear();
        target.tree.overlapping({box.lo.cast<float>(), box.hi.cast<float>()},
                                [&](std::uint32_t c) { found.push_back(c); });
        if (found.empty()) continue;
        std::sort(found.begin(), found.end());
        cubes.clear();
        for (const auto c : found) cubes.add({target.boxes[c], target.cubes[c]});
        const Arriving arriving{point.place, velocity, false, around,
                                [&] { return point.outward; }};
        const auto met = first_meeting(step, arriving, target, cubes, close);
        if (met) out.push_back(make_touch(scene, step, near, point, *met));
    }
}

}  // namespace

void add_feature_touches(const SolidsOverEdges& scene, std::vector<PlaneTouch>& out)
{
    if (!scene.body.outlines) return;
    const std::vector<NearPart> near = near_parts_of(scene);
    if (near.empty()) return;
    const StepOfParts step{scene.body.outlines->get(), scene.x, scene.v, scene.dt, Look::back};
    std::vector<std::vector<PlaneTouch>> found(near.size());
    geometry::parallel_for(near.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) meet(scene, step, near[i], found[i]);
    });
    // A point that meets several parts keeps the one that it is deepest in.
    std::vector<PlaneTouch> all;
    for (const auto& list : found) all.insert(all.end(), list.begin(), list.end());
    std::stable_sort(all.begin(), all.end(), [&](const PlaneTouch& a, const PlaneTouch& b) {
        if (in_order(a, b) || in_order(b, a)) return in_order(a, b);
        return a.gap(scene.x) < b.gap(scene.x);
    });
    const auto same = [](const PlaneTouch& a, const PlaneTouch& b) {
        return a.point == b.point && a.other == b.other;
    };
    all.erase(std::unique(all.begin(), all.end(), same), all.end());
    out.insert(out.end(), all.begin(), all.end());
}

}  // namespace physics
