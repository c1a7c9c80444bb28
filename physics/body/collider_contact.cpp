#include "physics/body/collider_contact.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/sheet_edges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

// Map: distance to each kind of collider; where a path entered one (for fast points); sheets and
// meshes that move; the planes of a body's points; bodies that start inside a collider.

namespace physics {
namespace {

using geometry::Mat3;
using geometry::Transform;

constexpr double held_before = 1e-6;  // m, before the surface, where the way of a held point starts

Transform between(const Transform& a, const Transform& b, double share)
{
    if (a.isApprox(b, 0)) return b;
    const Eigen::Quaterniond qa(a.rotation()), qb(b.rotation());
    Transform out = Transform::Identity();
    out.linear() = qa.slerp(share, qb).toRotationMatrix();
    out.translation() = (1 - share) * a.translation() + share * b.translation();
    return out;
}

Touch touch_sphere(const PosedCollider& c, const Vec3& local)
{
    const double r = local.norm();
    return {r - c.radius, r > 0 ? Vec3(local / r) : Vec3(Vec3::UnitY())};
}

Touch touch_box(const PosedCollider& c, const Vec3& local)
{
    const Vec3 over = local.cwiseAbs() - c.half_size;
    const Vec3 side = local.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; });
    const Vec3 outside = over.cwiseMax(0);
    if (const double d = outside.norm(); d > 0) {
        return {d, outside.cwiseProduct(side) / d};
    }
    Eigen::Index axis = 0;
    const double deepest = over.maxCoeff(&axis);
    return {deepest, Vec3(Vec3::Unit(axis) * side[axis])};
}

Touch touch_mesh(const PosedCollider& c, const Vec3& p)
{
    const Vec3 margin = Vec3::Constant(c.reach + c.thickness);
    if (((p + margin).array() < c.mesh_bounds.lo.array()).any() ||
        ((p - margin).array() > c.mesh_bounds.hi.array()).any()) {
        return {};
    }
    auto hit = c.tree->closest(p, c.reach + c.thickness);
    if (!hit) {
        if (c.sheet || !c.tree->inside(p)) return {};
        hit = c.tree->closest(p);
        if (!hit) return {};
    }
    Touch out{hit.signed_distance(), hit.normal};
    if (c.mesh_before && c.frame > 0) {
        Vec3 moved = Vec3::Zero();
        const auto& corners = c.mesh->topology->triangles[hit.triangle];
        for (std::size_t i = 0; i < 3; ++i) {
            const auto k = corners[i];
            moved += hit.barycentric[static_cast<Eigen::Index>(i)] *
                     (c.mesh->positions[k] - c.mesh_before->positions[k]).cast<double>();
        }
        out.velocity = moved / c.frame;
        out.gap += c.behind * moved.dot(out.normal);
    }
    return out;
}

}  // namespace

PosedCollider pose_collider(const Collider& in, double share, double frame, double h, bool first,
                            double thickest)
{
    PosedCollider out;
    out.kind = in.kind;
    out.half_size = in.half_size;
    out.radius = in.radius;
    out.thickness = in.thickness + thickest;
    out.friction = in.friction;
    out.bounce = in.bounce;
    out.frame = frame;
    out.behind = 1 - share;
    out.start = in.before;
    out.end = in.pose;
    out.pose = between(in.before, in.pose, share);
    out.inverse = out.pose.inverse(Eigen::Isometry);
    if (in.kind == Collider::Kind::mesh) {
        out.mesh = in.mesh.get();
        const bool moves = in.mesh_before && in.mesh_before != in.mesh &&
                           in.mesh_before->positions.size() == in.mesh->positions.size() &&
                           (in.mesh_before->topology == in.mesh->topology ||
                            in.mesh_before->topology->triangles == in.mesh->topology->triangles);
        out.mesh_before = moves ? in.mesh_before.get() : nullptr;
        out.tree = in.tree ? in.tree : std::make_shared<const geometry::TriangleBvh>(*in.mesh);
        out.mesh_bounds = geometry::bounds(*in.mesh);
        if (moves) {
            out.mesh_bounds.add(geometry::bounds(*in.mesh_before));
            for (std::size_t k = 0; k < in.mesh->positions.size(); ++k) {
                const auto way = in.mesh->positions[k] - in.mesh_before->positions[k];
                out.longest = std::max(out.longest, double(way.norm()));
            }
        }
        out.reach = 2 * h;
        out.sheet = in.sheet;
        out.first = first;
    }
    return out;
}

double crease_of(const PosedCollider& collider)
{
    return collider.sheet ? 0.075 * collider.reach : 0;
}

Touch touch(const PosedCollider& c, const Vec3& p)
{
    Touch out;
    if (c.kind == Collider::Kind::mesh) {
        out = touch_mesh(c, p);
    } else {
        const Vec3 local = c.inverse * p;
        switch (c.kind) {
        case Collider::Kind::plane:
            out = {local.y(), Vec3::UnitY()};
            break;
        case Collider::Kind::sphere:
            out = touch_sphere(c, local);
            break;
        case Collider::Kind::box:
            out = touch_box(c, local);
            break;
        case Collider::Kind::mesh:
            break;
        }
        out.normal = c.pose.linear() * out.normal;
        if (c.frame > 0) out.velocity = (c.end * local - c.start * local) / c.frame;
    }
    out.gap -= c.thickness;
    return out;
}

namespace {

// Where a way first goes in, at the end of the step.
struct Entry {
    Vec3 point, normal;
    Vec3 velocity = Vec3::Zero();  // m/s, of the mesh there
};

// Where a way from outside leads into the ball of radius r about 0, be it beyond its end.
std::optional<Entry> entry_into_ball(double r, const Vec3& from, const Vec3& way)
{
    const double a = way.squaredNorm(), b = from.dot(way), c = from.squaredNorm() - r * r;
    const double root = b * b - a * c;
    if (!(c >= 0 && b < 0 && root > 0)) return std::nullopt;
    const Vec3 point = from + c / (std::sqrt(root) - b) * way;
    return Entry{point, point.normalized()};
}

// The same for the box of `half` its size, within the way.
std::optional<Entry> entry_into_box(const Vec3& half, const Vec3& from, const Vec3& way)
{
    double in = -1, out = 1;  // shares of the way
    Eigen::Index axis = 0;
    for (Eigen::Index d = 0; d < 3; ++d) {
        const double side = way[d] > 0 ? -1 : 1;  // the one it meets first
        const double ahead = half[d] - side * from[d], steps = -side * way[d];
        if (steps == 0) {
            if (ahead < 0 || ahead > 2 * half[d]) return std::nullopt;
            continue;
        }
        if (-ahead / steps > in) in = -ahead / steps, axis = d;
        out = std::min(out, (2 * half[d] - ahead) / steps);
    }
    if (in < 0 || in > out) return std::nullopt;
    return Entry{from + in * way, Vec3(Vec3::Unit(axis) * (way[axis] > 0 ? -1 : 1))};
}

// Into a mesh, by the way of a point that came from one place to another within dt seconds.
std::optional<Entry> entry_into_mesh(const PosedCollider& c, const Vec3& from, const Vec3& to,
                                     double dt)
{
    using Bvh = geometry::TriangleBvh;
    const auto faces = c.sheet ? Bvh::Faces::both : Bvh::Faces::front;
    if (!c.mesh_before || !(c.frame > 0)) {
        const auto hit = c.tree->entry(from, to, faces);
        return hit ? std::optional(Entry{hit.point, hit.normal}) : std::nullopt;
    }
    const Bvh::Motion motion{
        c.mesh_before->positions,    c.mesh->positions, c.mesh->topology->triangles,
        1 - c.behind - dt / c.frame, 1 - c.behind,      c.longest};
    const auto hit = c.tree->entry(from, to, faces, &motion);
    if (!hit) return std::nullopt;
    const Vec3 way = motion.way(hit.triangle, hit.barycentric);
    return Entry{hit.point - c.behind * way, hit.normal, way / c.frame};
}

std::optional<Entry> entry_of(const PosedCollider& c, const Vec3& from, const Vec3& way)
{
    std::optional<Entry> entry;
    const Vec3 local = c.inverse * from, along = c.inverse.linear() * way;
    if (c.kind == Collider::Kind::sphere) entry = entry_into_ball(c.radius, local, along);
    if (c.kind == Collider::Kind::box) entry = entry_into_box(c.half_size, local, along);
    if (entry) *entry = {c.pose * entry->point, c.pose.linear() * entry->normal};
    return entry;
}

// A point that went along `way` from where `held` has it on its side of the collider. At a crease
// of a sheet it may be farther behind the next face than it was behind the plane that held it.
Vec3 start_of(const PosedCollider& c, const Vec3& to, const Vec3& way, const Grip* held)
{
    const Vec3 from = to - (1 + 1e-6) * way;
    if (!held) return from;
    const double before = held_before + crease_of(c);
    return from + (1.01 * double(held->depth) + before) * held->normal.cast<double>();
}

// Before a sheet on the side that it comes from, or through it.
Touch touch_sheet(const PosedCollider& c, const Vec3& to, const Vec3& way, double dt,
                  const Grip* held)
{
    if (const auto entry = entry_into_mesh(c, start_of(c, to, way, held), to, dt)) {
        return {(to - entry->point).dot(entry->normal) - c.thickness, entry->normal,
                entry->velocity};
    }
    Touch t = touch_mesh(c, to);
    if (t.gap < 0) t.gap = -t.gap, t.normal = -t.normal;
    t.gap -= c.thickness;
    return t;
}

// The same for a mesh with an inside that moves.
Touch touch_moving(const PosedCollider& c, const Vec3& to, const Vec3& way, double dt,
                   const Grip* held)
{
    const Touch t = touch(c, to);
    const bool far = !std::isfinite(t.gap);
    const Vec3 relative = way - dt * t.velocity;
    if (!far && t.gap + c.thickness >= relative.norm() && !held) return t;
    const auto entry = entry_into_mesh(c, start_of(c, to, way, held), to, dt);
    if (!entry || !(far || entry->normal.dot(t.normal) < -0.5)) return t;
    return {(to - entry->point).dot(entry->normal) - c.thickness, entry->normal, entry->velocity};
}

}  // namespace

Touch touch(const PosedCollider& c, const Vec3& to, const Vec3& v, double dt, const Grip* held)
{
    if (c.sheet && !(c.first && !held && touch_mesh(c, to - dt * v).gap < 0)) {
        return touch_sheet(c, to, dt * v, dt, held);
    }
    if (c.mesh_before) return touch_moving(c, to, dt * v, dt, held);
    Touch t = touch(c, to);
    if (c.kind == Collider::Kind::plane) return t;
    const bool far = !std::isfinite(t.gap);
    // As the collider sees it, and a bit of what went before: it may have started on the surface.
    const Vec3 from = start_of(c, to, dt * (v - t.velocity), held), way = to - from;
    const double length = way.norm(), gap = t.gap + c.thickness;
    // Nothing that near, or it is on its way in through the side that it is nearest to.
    if (far ? length <= c.reach : gap >= length) return t;
    if (gap < 0 && (way.dot(t.normal) <= 0 || length < -gap)) return t;
    // Through, and not over an edge.
    const auto opposite = [&](const Vec3& n) { return far || n.dot(t.normal) < -0.5; };
    const auto entry =
        c.kind == Collider::Kind::mesh ? entry_into_mesh(c, from, to, dt) : entry_of(c, from, way);
    if (entry) {
        if (!opposite(entry->normal)) return t;
        t.normal = entry->normal;
        t.gap = (to - entry->point).dot(t.normal) - c.thickness;
        return t;
    }
    const Touch before = touch(c, from);
    if (before.gap < 0 && way.dot(before.normal) < 0 && opposite(before.normal)) {
        t.normal = before.normal;
        t.gap = before.gap + way.dot(before.normal);
    }
    return t;
}

namespace {

Vec3 at(const double* field, std::uint32_t slot)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{slot});
}

}  // namespace

bool may_touch(const PosedCollider& c, const Vec3& p, double radius, double speed, double dt)
{
    if (c.kind != Collider::Kind::mesh) {
        const Touch t = touch(c, p);
        return t.gap <= radius + dt * (speed + t.velocity.norm());
    }
    const Vec3 margin = Vec3::Constant(radius + dt * speed + c.thickness);
    return ((p + margin).array() >= c.mesh_bounds.lo.array()).all() &&
           ((p - margin).array() <= c.mesh_bounds.hi.array()).all();
}

namespace {

// A step's view of a body's surface and the colliders.
struct Scene {
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
struct Found {
    std::vector<PlaneTouch> touches;
    std::vector<CornerStand> stands;  // of sheets
};

// The plane of a point, number i of the surface, on cube c.
void add_touch(const Scene& scene, const PlaneTouch& point, std::size_t c, std::uint32_t i,
               Found& found)
{
    std::vector<PlaneTouch>& out = found.touches;
    const ContactSurface& surface = scene.surface;
    const PosedCollider& collider = scene.colliders[point.other];
    Vec3 p = Vec3::Zero(), velocity = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        p += double(point.weight[a]) * at(scene.x, point.corners[a]);
        velocity += double(point.weight[a]) * at(scene.v, point.corners[a]);
    }
    const Grip* const held = find_grip(scene.held, point.point, point.other);
    Touch t = touch(collider, p, velocity, scene.dt, held);
    if (!surface.half_thickness.empty()) add_stand(collider, point, t, found.stands);
    t.gap += surface.thinner_by(c);
    const double h = scene.body.edge_at(point.corners[0]);
    if (!(t.gap < known_before * h)) return;
    PlaneTouch& touch = out.emplace_back(point);
    const double area = double(surface.point_area[i]);
    const double way = scene.dt * (t.velocity - velocity).dot(t.normal);  // in, m
    const double mass = double(surface.mass[c]) * std::min(1.0, area / (h * h));
    const double least = std::min(10 * double(surface.stiffness[c]) * area / h, scene.stiffest);
    touch.stiffness = stopping(least, mass, way, scene.dt, h);
    touch.at_rest = stopping(least, mass, 0, scene.dt, h);
    if (!(touch.stiffness > 0)) {  // it stands for no area
        out.pop_back();
        return;
    }
    touch.size = h;
    touch.normal = t.normal;
    touch.drift = t.velocity;
    touch.friction = collider.friction;
    touch.bounce = collider.bounce;
    touch.offset = t.gap - t.normal.dot(p);
}

// The colliders that points on cube c may touch.
void find_near(const Scene& scene, std::size_t c, const CornerRuns::Corners& corners,
               std::vector<std::uint32_t>& near)
{
    Vec3 centre = Vec3::Zero();
    for (const auto k : corners) centre += at(scene.x, k) / 8;
    double radius = 0, speed = 0;
    for (const auto k : corners) {
        radius = std::max(radius, (at(scene.x, k) - centre).norm());
        speed = std::max(speed, at(scene.v, k).norm());
    }
    const double reach = 1.5 * double(scene.surface.on(c).reach) * radius +
                         known_before * scene.body.edge_at(corners[0]) + scene.deepest;
    near.clear();
    for (std::uint32_t i = 0; i < scene.colliders.size(); ++i) {
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
    const Scene scene{body, surface, x, v, colliders, held, dt, stiffest, deepest_of(held)};
    std::vector<Found> found((cubes + grain - 1) / grain);
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
    Found all;
    for (const auto& [touches, stands] : found) {
        all.touches.insert(all.touches.end(), touches.begin(), touches.end());
        all.stands.insert(all.stands.end(), stands.begin(), stands.end());
    }
    add_edge_touches({body, x, v, colliders, dt, stiffest, all.stands}, all.touches);
    return std::move(all.touches);
}

// How deep a corner of the cubes at rest lies in the collider, m; 0: none does. The first of the
// corners is number `first` of those that the pins count.
static double deepest_corner(const PosedCollider& collider, const geometry::Cubes& cubes,
                             std::size_t first, const Pins& pins)
{
    const std::size_t stride = 1 + cubes.corner_count() / 20'000;
    double deepest = 0;
    for (std::size_t k = 0; k < cubes.corner_count(); k += stride) {
        const auto corner = static_cast<std::uint32_t>(first + k);
        const auto pin = std::lower_bound(pins.corner.begin(), pins.corner.end(), corner);
        const auto number = static_cast<std::size_t>(pin - pins.corner.begin());
        if (pin != pins.corner.end() && *pin == corner && held_axes(pins, number) == all_axes) {
            continue;
        }
        deepest = std::max(deepest, -touch(collider, cubes.corner_position(k)).gap);
    }
    return deepest;
}

// The same of a mesh's vertices.
static double deepest_vertex(const PosedCollider& collider, const geometry::TriMesh& mesh)
{
    double deepest = 0;
    for (const auto& p : mesh.positions) {
        if (!p.allFinite()) continue;
        deepest = std::max(deepest, -touch(collider, p.cast<double>()).gap);
    }
    return deepest;
}

std::vector<std::string> buried(ModelsOfState models, const Pins& pins,
                                std::span<const Collider> colliders, SurfacesOfModels surfaces)
{
    std::vector<std::string> out;
    double size = 0;
    for (const auto& cubes : models) size = std::max(size, cubes->size);
    for (std::size_t i = 0; i < colliders.size(); ++i) {
        const PosedCollider collider = pose_collider(colliders[i], 1, 0, size);
        std::size_t first = 0;
        for (std::size_t m = 0; m < models.size(); ++m) {
            const geometry::Cubes& cubes = *models[m];
            double deepest = deepest_corner(collider, cubes, first, pins);
            first += cubes.corner_count();
            if (!surfaces.empty() && deepest > cubes.size) {
                deepest = std::min(deepest, deepest_vertex(collider, *surfaces[m]));
            }
            if (!(deepest > cubes.size)) continue;
            const std::string name = models.size() == 1
                                         ? "The body"
                                         : fmt::format("Body {} of {}", m + 1, models.size());
            out.push_back(fmt::format(
                "{} starts up to {:.2g} m inside collider {} of {} and will be pushed out fast. "
                "Move them apart, or pin the corners that must stay.",
                name, deepest, i + 1, colliders.size()));
        }
    }
    return out;
}

}  // namespace physics
