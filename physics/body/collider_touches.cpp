#include "physics/body/collider_touches.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/body/feature_touches.hpp"
#include "physics/body/sheet_edges.hpp"
#include "physics/body/solids_beside_sheets.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace physics {
namespace {

// A step's view of a body's surface and the colliders.
struct SurfaceScene {
    const CornerBody& body;
    const ContactSurface& surface;
    const double* x;
    const double* v;
    const std::vector<PosedCollider>& colliders;
    const std::vector<Grip>& held;
    double dt;
    double stiffest;  // N/m
    double deepest;   // m, that a point is held in a collider
};

// What is found of some cubes.
struct FoundOnCubes {
    std::vector<PlaneTouch> touches;
    std::vector<CornerStand> stands;  // of sheets
};

// The plane of a point, number i of the surface, on cube c.
void add_touch(const SurfaceScene& scene, const PlaneTouch& point, std::size_t c, std::uint32_t i,
               FoundOnCubes& found)
{
    std::vector<PlaneTouch>& out = found.touches;
    const ContactSurface& surface = scene.surface;
    const PosedCollider& collider = scene.colliders[point.other];
    Vec3 p = Vec3::Zero(), velocity = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        p += double(point.weight[a]) * corner_place(scene.x, point.corners[a]);
        velocity += double(point.weight[a]) * corner_place(scene.v, point.corners[a]);
    }
    const Grip* const held = find_grip(scene.held, point.point, point.other);
    Touch t = touch(collider, p, velocity, scene.dt, held);
    if (!surface.half_thickness.empty() && surface.half_thickness[c] > 0)
        add_stand(collider, point, t, found.stands);
    t.gap += surface.thinner_by(c);
    const double h = scene.body.edge_at(point.corners[0]);
    if (!(t.gap < known_before * h)) return;
    PlaneTouch& touch = out.emplace_back(point);
    const double area = double(surface.point_area[i]);
    const double way = scene.dt * (t.velocity - velocity).dot(t.normal);  // in, m
    const double mass = double(surface.mass[c]) * std::min(1.0, area / (h * h));
    const double young =
        softer_of(scene.body, scene.colliders.size(), point.other, double(surface.stiffness[c]));
    const double least = std::min(10 * young * area / h, scene.stiffest);
    touch.stiffness = stopping(least, mass, way, scene.dt, h);
    touch.at_rest = stopping(least, mass, 0, scene.dt, h);
    if (!(touch.stiffness > 0)) {  // it stands for no area
        out.pop_back();
        return;
    }
    touch.size = h;
    touch.normal = t.normal;
    touch.drift = carrying(collider, t, p, velocity, scene.dt);
    touch.friction = collider.friction;
    touch.bounce = collider.bounce;
    touch.offset = t.gap - t.normal.dot(p);
}

// The colliders that points on cube c may touch.
void find_near(const SurfaceScene& scene, std::size_t c, const CornerRuns::Corners& corners,
               std::vector<std::uint32_t>& near)
{
    Vec3 centre = Vec3::Zero();
    for (const auto k : corners) centre += corner_place(scene.x, k) / 8;
    double radius = 0, speed = 0;
    for (const auto k : corners) {
        radius = std::max(radius, (corner_place(scene.x, k) - centre).norm());
        speed = std::max(speed, corner_place(scene.v, k).norm());
    }
    const double reach = 1.5 * double(scene.surface.on(c).reach) * radius +
                         known_before * scene.body.edge_at(corners[0]) + scene.deepest;
    near.clear();
    std::size_t count = scene.colliders.size();
    const SolidsBesideSheets* const solids = scene.body.solids.get();
    if (solids && c < solids->first_sheet_cell) count -= solids->solid.size();
    for (std::uint32_t i = 0; i < count; ++i) {
        if (may_touch(scene.colliders[i], centre, reach, speed, scene.dt)) near.push_back(i);
    }
}

}  // namespace

std::vector<PlaneTouch> find_collider_touches(const CornerBody& body, const double* x,
                                              const double* v,
                                              const std::vector<PosedCollider>& colliders,
                                              const std::vector<Grip>& held, double dt)
{
    constexpr std::size_t grain = 256;  // cubes
    const ContactSurface& surface = body.skin;
    const std::size_t cubes = surface.corners.size();
    if (colliders.empty() || cubes == 0) return {};
    const double stiffest = 1000 * surface.body_mass * 9.81 / body.h;
    const SurfaceScene scene{body, surface, x, v, colliders, held, dt, stiffest, deepest_of(held)};
    std::vector<FoundOnCubes> found((cubes + grain - 1) / grain);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> near;
        PlaneTouch touch;
        touch.count = 8;
        for (std::size_t g = begin; g < end; ++g) {
            const std::size_t last = std::min(cubes, (g + 1) * grain);
            surface.corners.for_each(g * grain, last, [&](std::size_t c, const auto& corners) {
                find_near(scene, c, corners, near);
                if (near.empty()) return;
                std::copy(corners.begin(), corners.end(), touch.corners.begin());
                const SurfacePatch& patch = surface.on(c);
                for (std::uint32_t i = patch.point; i < patch.points_end; ++i) {
                    const auto& weight = surface.point[i];
                    std::copy(weight.begin(), weight.end(), touch.weight.begin());
                    touch.point = surface.first_point[c] + (i - patch.point);
                    for (const auto collider : near) {
                        touch.other = collider;
                        add_touch(scene, touch, c, i, found[g]);
                    }
                }
            });
        }
    });
    FoundOnCubes all;
    for (const auto& [touches, stands] : found) {
        all.touches.insert(all.touches.end(), touches.begin(), touches.end());
        all.stands.insert(all.stands.end(), stands.begin(), stands.end());
    }
    add_edge_touches({body, x, v, colliders, dt, stiffest, all.stands}, all.touches);
    add_feature_touches({body, x, v, colliders, dt, stiffest}, all.touches);
    return std::move(all.touches);
}

}  // namespace physics
