#include "physics/body/collider_contact.hpp"

#include "geometry/mesh/same_triangles.hpp"

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

// rad, from one to the other.
Vec3 turn_between(const Transform& a, const Transform& b)
{
    if (a.linear() == b.linear()) return Vec3::Zero();
    const Eigen::AngleAxisd turn(Mat3(b.rotation() * a.rotation().transpose()));
    return turn.angle() * turn.axis();
}

// How fast the surface moves out as the collider grows, where its normal is this one, m/s.
Vec3 growing(const PosedCollider& c, const Vec3& normal)
{
    double speed = c.grows.thickness;
    if (c.kind == Collider::Kind::sphere) speed += c.grows.radius;
    if (c.kind == Collider::Kind::box) {
        speed += (c.inverse.linear() * normal).cwiseAbs().dot(c.grows.half_size);
    }
    return speed * normal;
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

// How a triangle turns within the frame; not at all where its sides do not keep their lengths.
Eigen::AngleAxisd turn_of(const PosedCollider& c, std::uint32_t triangle)
{
    constexpr double alike = 0.01;
    const auto& corners = c.mesh->topology->triangles[triangle];
    const auto sides_of = [&](const geometry::TriMesh& mesh) {
        const Vec3 a = mesh.positions[corners[0]].cast<double>();
        return std::array<Vec3, 2>{mesh.positions[corners[1]].cast<double>() - a,
                                   mesh.positions[corners[2]].cast<double>() - a};
    };
    const auto axes_of = [&](const std::array<Vec3, 2>& sides) {
        Mat3 axes;
        axes.col(0) = sides[0].normalized();
        axes.col(1) = sides[0].cross(sides[1]).normalized();
        axes.col(2) = axes.col(0).cross(axes.col(1));
        return axes;
    };
    const auto before = sides_of(*c.mesh_before), after = sides_of(*c.mesh);
    bool rigid = before != after;
    for (std::size_t i = 0; i < 2; ++i) {
        rigid = rigid && std::abs(after[i].norm() - before[i].norm()) <= alike * before[i].norm();
    }
    const Mat3 turn = axes_of(after) * axes_of(before).transpose();
    const bool known = rigid && std::abs(turn.determinant() - 1) < 1e-6;
    return known ? Eigen::AngleAxisd(turn) : Eigen::AngleAxisd(0, Vec3::UnitY());
}

// As a triangle is turned when a share of its turn has gone by.
Mat3 share_of(const Eigen::AngleAxisd& turn, double share)
{
    return Eigen::AngleAxisd(share * turn.angle(), turn.axis()).toRotationMatrix();
}

// The velocity of a place on a triangle that went along a chord within the frame, now. What turns
// goes along its chord only in the middle of the frame.
Vec3 velocity_of_chord(const PosedCollider& c, const Eigen::AngleAxisd& turn, const Vec3& chord)
{
    return share_of(turn, 0.5 - c.behind) * chord / c.frame;
}

// How far the place of a hit goes within the frame.
Vec3 way_of(const PosedCollider& c, const geometry::TriangleBvh::Hit& hit)
{
    Vec3 way = Vec3::Zero();
    const auto& corners = c.mesh->topology->triangles[hit.triangle];
    for (std::size_t i = 0; i < 3; ++i) {
        const auto k = corners[i];
        way += hit.barycentric[static_cast<Eigen::Index>(i)] *
               (c.mesh->positions[k] - c.mesh_before->positions[k]).cast<double>();
    }
    return way;
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
    if (!c.mesh_before || !(c.frame > 0)) return {hit.signed_distance(), hit.normal};
    // What is at p now has come to elsewhere by the end of the frame, where the tree knows it.
    Vec3 asked = p;
    if (c.behind > 0) {
        const Vec3 later = p + c.behind * way_of(c, hit);
        if (const auto there = c.tree->closest(later, c.reach + c.thickness)) {
            hit = there, asked = later;
        }
    }
    const Vec3 way = way_of(c, hit);
    const Eigen::AngleAxisd turn = turn_of(c, hit.triangle);
    return {hit.signed_distance() + hit.normal.dot(p + c.behind * way - asked),
            share_of(turn, -c.behind) * hit.normal, velocity_of_chord(c, turn, way), way,
            turn.angle() * turn.axis()};
}

}  // namespace

void turn_touch(const PosedCollider& c, const Vec3& normal, Touch& touch)
{
    touch.velocity += growing(c, normal) - growing(c, touch.normal);
    touch.normal = normal;
}

PosedCollider pose_collider(const Collider& in, double share, double frame, double h, bool first,
                            double thickest)
{
    PosedCollider out;
    out.kind = in.kind;
    const ColliderSize to = in.size(), from = in.size_before.value_or(to);
    out.half_size = from.half_size + share * (to.half_size - from.half_size);
    out.radius = from.radius + share * (to.radius - from.radius);
    out.thickness = from.thickness + share * (to.thickness - from.thickness) + thickest;
    out.friction = in.friction, out.bounce = in.bounce;
    out.frame = frame, out.behind = 1 - share;
    out.pose = between(in.before, in.pose, share);
    if (frame > 0) {
        out.slides = (in.pose.translation() - in.before.translation()) / frame;
        out.turns = turn_between(in.before, in.pose) / frame;
        out.grows = {(to.radius - from.radius) / frame, (to.half_size - from.half_size) / frame,
                     (to.thickness - from.thickness) / frame};
    }
    out.inverse = out.pose.inverse(Eigen::Isometry);
    if (in.kind == Collider::Kind::mesh) {
        out.mesh = in.mesh.get();
        const bool moves = geometry::has_moved(in.mesh_before.get(), *in.mesh);
        out.mesh_before = moves ? in.mesh_before.get() : nullptr;
        out.tree = in.tree ? in.tree : std::make_shared<const geometry::TriangleBvh>(*in.mesh);
        out.mesh_bounds = geometry::bounds(*in.mesh);
        if (!moves) out.features = in.features;
        if (moves) {
            out.mesh_bounds.add(geometry::bounds(*in.mesh_before));
            for (std::size_t k = 0; k < in.mesh->positions.size(); ++k) {
                const auto way = in.mesh->positions[k] - in.mesh_before->positions[k];
                out.longest = std::max(out.longest, double(way.norm()));
            }
        }
        out.reach = 2 * h;
        out.sheet = in.sheet, out.first = first;
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
        // Not along the chord of the frame: what turns in itself does not come out of itself.
        out.velocity = c.slides + c.turns.cross(p - c.pose.translation());
    }
    out.gap -= c.thickness;
    out.velocity += growing(c, out.normal);
    return out;
}

namespace {

// Where a way first goes in, at the end of the step.
struct Entry {
    Vec3 point, normal;
    Vec3 velocity = Vec3::Zero();                    // m/s, of the mesh there
    Vec3 chord = Vec3::Zero(), turn = Vec3::Zero();  // as those of a Touch
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
    const Eigen::AngleAxisd turn = turn_of(c, hit.triangle);
    return Entry{hit.point - c.behind * way, share_of(turn, -c.behind) * hit.normal,
                 velocity_of_chord(c, turn, way), way, turn.angle() * turn.axis()};
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

// Before the face that it went in by.
Touch before(const PosedCollider& c, const Entry& entry, const Vec3& to)
{
    return {(to - entry.point).dot(entry.normal) - c.thickness, entry.normal,
            entry.velocity + growing(c, entry.normal), entry.chord, entry.turn};
}

// Whether what comes to a place at velocity v lay within the reach behind the front of a sheet when
// the frame began: later the sheet may have come to it from behind.
bool began_behind(const PosedCollider& c, const Vec3& to, const Vec3& v, double dt)
{
    const Vec3 from = to - (c.frame > 0 ? (1 - c.behind) * c.frame : dt) * v;
    PosedCollider then = c;
    then.behind = 1;
    const double gap = touch_mesh(then, from).gap;
    return gap < 0 && gap > -(c.reach + c.thickness);
}

// Before a sheet on the side that it comes from, or through it.
Touch touch_sheet(const PosedCollider& c, const Vec3& to, const Vec3& way, double dt,
                  const Grip* held)
{
    if (const auto entry = entry_into_mesh(c, start_of(c, to, way, held), to, dt)) {
        return before(c, *entry, to);
    }
    Touch t = touch_mesh(c, to);
    if (t.gap < 0) t.gap = -t.gap, t.normal = -t.normal;
    t.gap -= c.thickness;
    t.velocity += growing(c, t.normal);
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
    return before(c, *entry, to);
}

}  // namespace

Touch touch(const PosedCollider& c, const Vec3& to, const Vec3& v, double dt, const Grip* held)
{
    if (c.sheet && !(c.first && !held && began_behind(c, to, v, dt))) {
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
        turn_touch(c, entry->normal, t);
        t.gap = (to - entry->point).dot(t.normal) - c.thickness;
        return t;
    }
    const Touch before = touch(c, from);
    if (before.gap < 0 && way.dot(before.normal) < 0 && opposite(before.normal)) {
        turn_touch(c, before.normal, t);
        t.gap = before.gap + way.dot(before.normal);
    }
    return t;
}

namespace {

Mat3 turn_by(const Vec3& turn)
{
    const double angle = turn.norm();
    if (!(angle > 0)) return Mat3::Identity();
    return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

// What a mesh that moves took along from a place, m/s. Its places go along straight lines within a
// frame, those about the touch as its triangle turns.
Vec3 carried_by_mesh(const PosedCollider& c, const Touch& t, const Vec3& from, const Vec3& to,
                     double dt)
{
    const double gone = dt / c.frame, start = 1 - c.behind - gone;  // shares of the frame
    const Mat3 turned = turn_by(t.turn) - Mat3::Identity();
    const Vec3 away = from - (to - gone * t.chord);
    const Vec3 at_first = (Mat3::Identity() + start * turned).inverse() * away;
    return (t.chord + turned * at_first) / c.frame;
}

}  // namespace

Vec3 carrying(const PosedCollider& c, const Touch& t, const Vec3& to, const Vec3& v, double dt)
{
    const Vec3& turn = c.mesh_before ? t.turn : c.turns;
    if (!(dt > 0) || turn.isZero(0)) return t.velocity;
    const Vec3 from = to - dt * v;
    Vec3 mean;
    if (c.mesh_before) {
        mean = carried_by_mesh(c, t, from, to, dt);
    } else {
        const Vec3 arm = from - (c.pose.translation() - dt * c.slides);
        mean = c.slides + (turn_by(dt * c.turns) * arm - arm) / dt;
    }
    return mean + (t.velocity - mean).dot(t.normal) * t.normal;
}

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
                "{} starts up to {:.2g} m inside collider {} of {} and will be pushed out. "
                "Move them apart, or pin the corners that must stay.",
                name, deepest, i + 1, colliders.size()));
        }
    }
    return out;
}

}  // namespace physics
