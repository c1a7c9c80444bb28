#include "render/marker.hpp"

#include "geometry/mesh/normals.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "physics/state/hold_matter.hpp"
#include "render/captions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace render {

using geometry::Transform;

static double head_length(double length, double width)
{
    return std::min(1.6 * width, 0.5 * length);
}

TriMesh arrow(const Vec3& from, const Vec3& to, double width)
{
    TriMesh mesh;
    const Vec3 along = to - from;
    const double length = along.norm();
    if (!(length > 0) || !std::isfinite(length)) return mesh;
    const Vec3 axis = along / length, side = axis.unitOrthogonal(), up = axis.cross(side);
    const double head = head_length(length, width);

    // A profile turned about the axis: distance along it and radius.
    const std::array<std::array<double, 2>, 6> profile = {{{0, 0},
                                                           {0, 0.16 * width},
                                                           {length - head, 0.16 * width},
                                                           {length - head, 0.5 * width},
                                                           {length - 0.02 * head, 0.01 * width},
                                                           {length, 0}}};
    constexpr std::uint32_t around = 24;
    for (const auto& [at, radius] : profile) {
        for (std::uint32_t k = 0; k < around; ++k) {
            const double angle = 2 * std::numbers::pi * k / around;
            const Vec3 p =
                from + at * axis + radius * (std::cos(angle) * side + std::sin(angle) * up);
            mesh.positions.push_back(p.cast<float>());
        }
    }
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (std::uint32_t ring = 0; ring + 1 < profile.size(); ++ring) {
        for (std::uint32_t k = 0; k < around; ++k) {
            const std::uint32_t a = ring * around + k, b = ring * around + (k + 1) % around;
            topology->triangles.push_back({a, b, b + around});
            topology->triangles.push_back({a, b + around, a + around});
        }
    }
    mesh.topology = topology;
    geometry::compute_normals(mesh, 0.6);
    return mesh;
}

namespace {

double arrow_width(const Box& stage)
{
    return 0.03 * stage.diagonal();
}

struct ForceArrow {
    Vec3 from, tip;
};

// 0.06 of a stage of that size, so that it is seen, to 0.24 of it, half of that at `half`.
double arrow_length(double size, double amount, double half)
{
    return amount > 0 ? size * std::max(0.06, 0.24 * amount / (amount + half)) : 0;
}

std::vector<ForceArrow> wind_arrows(const Vec3& velocity, const Box& stage)
{
    const double speed = velocity.norm(), size = stage.diagonal();
    if (!(speed > 0)) return {};
    const Vec3 towards = velocity / speed, half = 0.5 * stage.size();
    const Vec3 tip =
        stage.centre() - towards * (half.cwiseProduct(towards.cwiseAbs()).sum() + 0.03 * size);
    Vec3 beside = Vec3(0, 1, 0).cross(towards);
    beside = beside.norm() > 1e-6 ? Vec3(beside.normalized()) : Vec3(1, 0, 0);
    std::vector<ForceArrow> out;
    for (const double k : {-1.0, 0.0, 1.0}) {
        const Vec3 at = tip + 0.12 * k * size * beside;
        out.push_back({at - arrow_length(size, speed, 5) * towards, at});
    }
    return out;
}

// Six, away from the place or towards it, or along the swirl.
std::vector<ForceArrow> radial_arrows(const physics::Force& force, const Box& stage)
{
    const double size = stage.diagonal();
    std::vector<ForceArrow> out;
    for (const Vec3& side : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
        for (const double sign : {1.0, -1.0}) {
            const Vec3 from = 0.05 * size * sign * side;
            const Vec3 push = sign * (force.outward * side + force.swirl.cross(side));
            const double strength = push.norm();
            if (!(strength > 0)) continue;
            const Vec3 way = arrow_length(size, strength, 9.81) / strength * push;
            const bool inward = push.dot(from) < 0;
            const Vec3 begin = force.position + from - (inward ? way : Vec3(Vec3::Zero()));
            out.push_back({begin, begin + way});
        }
    }
    return out;
}

// Along its axis, with a second head behind the first, so that it is told from a force: an arrow
// within the arrow, which comes first.
std::vector<ForceArrow> torque_arrows(const physics::Force& force, const Box& stage, double half)
{
    const double amount = force.torque.norm();
    const double length = arrow_length(stage.diagonal(), amount, half);
    if (!(length > 0)) return {};
    const Vec3 axis = force.torque / amount;
    const double to_second = length - 0.9 * head_length(length, arrow_width(stage));
    return {{force.position, force.position + to_second * axis},
            {force.position, force.position + length * axis}};
}

std::vector<ForceArrow> arrows_of(const physics::Force& force, const Box& stage, double weight)
{
    using Kind = physics::Force::Kind;
    const double size = stage.diagonal();
    if (force.kind == Kind::wind) return wind_arrows(force.velocity, stage);
    if (force.kind == Kind::point) {
        const double newtons = force.force.norm();
        const double length = arrow_length(size, newtons, std::max(weight, 1e-9));
        if (newtons > 0) return {{force.position - length / newtons * force.force, force.position}};
    }
    if (force.kind == Kind::torque) {
        return torque_arrows(force, stage, std::max(0.5 * size * weight, 1e-9));
    }
    if (force.kind == Kind::radial) return radial_arrows(force, stage);
    if (force.kind == Kind::gravity) {
        const double g = force.acceleration.norm(), length = arrow_length(size, g, 9.81);
        const Vec3 from(stage.lo.x() - 0.04 * size, stage.hi.y() + 0.04 * size, stage.lo.z());
        if (g > 0) return {{from, from + length / g * force.acceleration}};
    }
    return {};
}

}  // namespace

std::vector<TriMesh> force_arrows(const physics::Force& force, const Box& stage, double weight)
{
    std::vector<TriMesh> out;
    for (const ForceArrow& a : arrows_of(force, stage, weight)) {
        TriMesh made = arrow(a.from, a.tip, arrow_width(stage));
        if (!made.positions.empty()) out.push_back(std::move(made));
    }
    return out;
}

static std::string strength_of(const physics::Force& force)
{
    using Kind = physics::Force::Kind;
    switch (force.kind) {
    case Kind::wind:
        return quantity_text(force.velocity.norm(), "m/s");
    case Kind::point:
        return quantity_text(force.force.norm(), "N");
    case Kind::torque:
        return quantity_text(force.torque.norm(), "N m");
    case Kind::radial:
        return quantity_text(std::hypot(force.outward, force.swirl.norm()), "m/s^2");
    case Kind::pressure:
        return quantity_text(force.pressure, "Pa");
    case Kind::gravity:
        break;
    }
    return quantity_text(force.acceleration.norm(), "m/s^2");
}

std::optional<Note> force_note(const physics::Force& force, const Box& stage, double weight)
{
    const auto arrows = arrows_of(force, stage, weight);
    if (arrows.empty()) return std::nullopt;
    const ForceArrow& middle = arrows[arrows.size() / 2];
    return Note{middle.from, middle.tip, 0.5 * arrow_width(stage), strength_of(force)};
}

std::shared_ptr<const TriMesh> collider_surface(const physics::Collider& collider, const Box& stage)
{
    using Kind = physics::Collider::Kind;
    if (collider.kind == Kind::mesh) return collider.mesh;
    TriMesh mesh;
    if (collider.kind == Kind::sphere) mesh = geometry::icosphere(collider.radius, 4);
    if (collider.kind == Kind::box) mesh = geometry::box(2 * collider.half_size, {1, 1, 1});
    if (collider.kind == Kind::plane) {
        const double size = std::max(1e-6, 2 * stage.diagonal());
        mesh = geometry::grid(size, size, 1, 1);
    }
    geometry::move(mesh, collider.pose);
    return std::make_shared<const TriMesh>(std::move(mesh));
}

static Surface marker(std::shared_ptr<const TriMesh> mesh, const Vec3f& colour)
{
    Surface surface;
    surface.mesh = std::move(mesh);
    surface.paint.by = Paint::By::constant;
    surface.paint.colour = colour;
    return surface;
}

Balls pin_marks(const physics::Pins& pins, double radius)
{
    Balls balls;
    balls.radius = static_cast<float>(radius);
    balls.smallest = 3;
    balls.shadow = false;
    balls.colours = {Vec3f(0.85f, 0.16f, 0.02f)};
    for (const Vec3& p : pins.target) balls.centres.push_back(p.cast<float>());
    // Of what is held in a cube, one at its middle.
    for (const physics::HeldCube& cube : pins.matter.cubes) {
        balls.centres.push_back(physics::middle_of(pins.matter, cube).cast<float>());
    }
    return balls;
}

std::vector<Surface> force_marks(const physics::Force& force, const Box& stage, double weight)
{
    std::vector<Surface> out;
    for (TriMesh& mesh : force_arrows(force, stage, weight)) {
        out.push_back(
            marker(std::make_shared<const TriMesh>(std::move(mesh)), {0.05f, 0.30f, 0.65f}));
        out.back().shadow = false;
    }
    return out;
}

Surface ghost(std::shared_ptr<const TriMesh> mesh, float opacity)
{
    Surface surface = marker(std::move(mesh), {0.22f, 0.36f, 0.55f});
    surface.opacity = opacity;
    surface.shadow = false;
    surface.kind = Surface::Kind::ghost;
    return surface;
}

std::optional<Surface> collider_mark(const physics::Collider& collider, const Box& stage)
{
    auto mesh = collider_surface(collider, stage);
    if (!mesh) return std::nullopt;
    Surface surface = marker(std::move(mesh), {0.28f, 0.33f, 0.38f});
    if (collider.kind == physics::Collider::Kind::plane) {
        surface.opacity = 0.35f;
        surface.shadow = false;
    }
    return surface;
}

}  // namespace render
