#include "physics/layered_bodies/base.hpp"

#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>
#include <string>

namespace physics {

// Still ones too: whoever poses them needs to know how they are joined.
static bool has_limbs(const Base& base)
{
    return base.kind == BaseKind::rigid || base.kind == BaseKind::still;
}

Hinge& add_hinge(Base& base, std::uint32_t a, std::uint32_t b, const Vec3& point, const Vec3& axis)
{
    if (!has_limbs(base) || a >= base.frames.size() || b >= base.frames.size() || a == b) {
        throw std::invalid_argument(
            fmt::format("a hinge needs two different frames of a rigid or still body; got frames "
                        "{} and {} of {}{}",
                        a, b, base.frames.size(),
                        has_limbs(base) ? "" : " of a body that is neither rigid nor still"));
    }
    if (!(axis.norm() > 0) || !axis.allFinite() || !point.allFinite()) {
        throw std::invalid_argument("a hinge needs a finite point and an axis that is not zero");
    }
    const Vec3 along = axis.normalized(), square = along.unitOrthogonal();
    Hinge hinge{.a = a, .b = b};
    hinge.point_a = base.frames[a].inverse() * point;
    hinge.point_b = base.frames[b].inverse() * point;
    hinge.axis_a = base.frames[a].linear().transpose() * along;
    hinge.axis_b = base.frames[b].linear().transpose() * along;
    hinge.zero_a = base.frames[a].linear().transpose() * square;
    hinge.zero_b = base.frames[b].linear().transpose() * square;
    base.hinges.push_back(hinge);
    return base.hinges.back();
}

Joint& add_joint(Base& base, JointKind kind, std::uint32_t a, std::uint32_t b, const Vec3& point,
                 const Vec3& axis, const Vec3& second_axis)
{
    const bool to_world = a == Joint::world;
    if (!has_limbs(base) || (!to_world && a >= base.frames.size()) || b >= base.frames.size() ||
        a == b) {
        throw std::invalid_argument(
            fmt::format("a joint needs two different frames of a rigid or still body, or one and "
                        "the world; got frames "
                        "{} and {} of {}{}",
                        to_world ? "the world" : std::to_string(a), b, base.frames.size(),
                        has_limbs(base) ? "" : " of a body that is neither rigid nor still"));
    }
    if (!(axis.norm() > 0) || !axis.allFinite() || !point.allFinite()) {
        throw std::invalid_argument("a joint needs a finite point and an axis that is not zero");
    }
    Mat3 axes;
    axes.col(0) = axis.normalized();
    axes.col(1) = axes.col(0).unitOrthogonal();
    if (kind == JointKind::two_axis) {
        const Vec3 other = second_axis.normalized();
        if (!(std::abs(other.dot(axes.col(0))) < 1e-3) || !(other.norm() > 0.5)) {
            throw std::invalid_argument(
                "a joint of two axes needs a second axis that is square to the first");
        }
        axes.col(1) = (other - other.dot(axes.col(0)) * axes.col(0)).normalized();
    }
    axes.col(2) = axes.col(0).cross(axes.col(1));
    const Transform at_a = to_world ? Transform::Identity() : base.frames[a];
    Joint joint{.kind = kind, .a = a, .b = b};
    joint.point_a = at_a.inverse() * point;
    joint.point_b = base.frames[b].inverse() * point;
    joint.axes_a = at_a.linear().transpose() * axes;
    joint.axes_b = base.frames[b].linear().transpose() * axes;
    base.joints.push_back(joint);
    return base.joints.back();
}

double hinge_angle(const Hinge& hinge, const Transform& a, const Transform& b)
{
    const Vec3 axis = a.linear() * hinge.axis_a;
    const Vec3 za = a.linear() * hinge.zero_a, zb = b.linear() * hinge.zero_b;
    return unwound(hinge, std::atan2(za.cross(zb).dot(axis), za.dot(zb)));
}

constexpr double whole_turn = 2 * std::numbers::pi;

bool has_limits(const Hinge& hinge)
{
    constexpr double rounding = 1e-9;
    return hinge.highest - hinge.lowest < whole_turn - rounding;
}

double unwound(const Hinge& hinge, double angle)
{
    const double middle = has_limits(hinge) ? 0.5 * (hinge.lowest + hinge.highest) : hinge.rest;
    return angle - whole_turn * std::round((angle - middle) / whole_turn);
}

void add_spring_network(Base& base, double reach, double stiffness, double damping)
{
    const std::size_t before = base.springs.size();
    for (std::uint32_t a = 0; a < mass_count(base); ++a) {
        for (std::uint32_t b = a + 1; b < mass_count(base); ++b) {
            const double rest =
                (base.frames[a].translation() - base.frames[b].translation()).norm();
            if (rest < reach) base.springs.push_back({a, b, rest, stiffness, damping});
        }
    }
    if (base.springs.size() == before) {
        throw std::invalid_argument(fmt::format(
            "no two of the {} frames are nearer than {} m: raise reach", mass_count(base), reach));
    }
    base.substance.stiffness = base.substance.friction = 0;
}

void add_spring_edges(Base& base, const geometry::TriMesh& mesh, double reach, double stiffness,
                      double damping)
{
    std::vector<std::uint32_t> frame(mesh.positions.size(), Joint::world);
    for (std::size_t v = 0; v < frame.size(); ++v) {
        const Vec3 at = mesh.positions[v].cast<double>();
        double nearest = reach;
        for (std::uint32_t f = 0; f < mass_count(base); ++f) {
            const double distance = (base.frames[f].translation() - at).norm();
            if (distance < nearest) nearest = distance, frame[v] = f;
        }
    }
    std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
    for (const geometry::Triangle& t : mesh.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = frame[t[k]], b = frame[t[(k + 1) % 3]];
            if (a != Joint::world && b != Joint::world && a != b) pairs.insert(std::minmax(a, b));
        }
    }
    if (pairs.empty()) {
        throw std::invalid_argument(
            fmt::format("no edge of the mesh has frames within {} m of both its ends: put the "
                        "frames at its vertices, or raise reach",
                        reach));
    }
    for (const auto& [a, b] : pairs) {
        const double rest = (base.frames[a].translation() - base.frames[b].translation()).norm();
        base.springs.push_back({a, b, rest, stiffness, damping});
    }
    base.substance.stiffness = base.substance.friction = 0;
}

bool is_told(BaseKind kind)
{
    return kind == BaseKind::still || kind == BaseKind::led;
}

}  // namespace physics
