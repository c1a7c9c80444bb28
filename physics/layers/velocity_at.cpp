#include "physics/layers/velocity_at.hpp"

#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {

using geometry::Mat3;
using geometry::Skeleton;

Vec3 velocity_at(const MovingMesh& mesh, const Vec3& p)
{
    if (!(mesh.seconds > 0)) return Vec3::Zero();
    const geometry::TriangleBvh::Hit hit = mesh.now->tree.closest(p);
    if (!hit) return Vec3::Zero();
    Vec3 moved = Vec3::Zero();
    const geometry::Triangle& t = mesh.now->mesh.triangles()[hit.triangle];
    for (std::size_t k = 0; k < 3; ++k) {
        const geometry::Vec3f way = mesh.now->mesh.positions[t[k]] - mesh.before->positions[t[k]];
        moved += hit.barycentric[static_cast<int>(k)] * way.cast<double>();
    }
    return moved / mesh.seconds;
}

namespace {

// Shares of three corners at the point of their triangle nearest to p.
// Ericson. Real-time collision detection. Morgan Kaufmann 2005, 5.1.5.
Vec3 shares_on_triangle(const std::vector<Vec3>& corners, const Vec3& p)
{
    const Vec3 u = corners[1] - corners[0], v = corners[2] - corners[0], w = p - corners[0];
    const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
    if (det > 0) {
        const double b = (vv * u.dot(w) - uv * v.dot(w)) / det;
        const double c = (uu * v.dot(w) - uv * u.dot(w)) / det;
        if (b >= 0 && c >= 0 && b + c <= 1) return {1 - b - c, b, c};
    }
    Vec3 best = Vec3::UnitX();
    double nearest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(k), j = static_cast<std::size_t>((k + 1) % 3);
        const Vec3 edge = corners[j] - corners[i];
        const double length_sq = edge.squaredNorm();
        const double t =
            length_sq > 0 ? std::clamp(edge.dot(p - corners[i]) / length_sq, 0.0, 1.0) : 0;
        const double far = (corners[i] + t * edge - p).squaredNorm();
        if (!(far < nearest)) continue;
        nearest = far;
        best = Vec3::Zero();
        best[k] = 1 - t;
        best[(k + 1) % 3] = t;
    }
    return best;
}

}  // namespace

Vec3 shares_at(const std::vector<Vec3>& points, const Vec3& p)
{
    if (points.size() == 1) return Vec3::UnitX();
    if (points.size() == 3) return shares_on_triangle(points, p);
    const Vec3 along = points[1] - points[0];
    const double length_sq = along.squaredNorm();
    const double t = length_sq > 0 ? std::clamp(along.dot(p - points[0]) / length_sq, 0.0, 1.0) : 0;
    return {1 - t, t, 0};
}

namespace {

// Of skeletons that are drawn by points.
Vec3 way_of_points(const Skeleton& now, const Skeleton& before, const Skeleton& after,
                   const Vec3& place)
{
    // As distances are measured.
    std::vector<Vec3> narrow;
    Vec3 p = place;
    if (now.stretches()) {
        const Mat3 by = now.stretch.inverse();
        p = by * place;
        for (const Vec3& q : now.points) narrow.emplace_back(by * q);
    }
    const std::vector<Vec3>& at = now.stretches() ? narrow : now.points;
    const auto way = [&](std::size_t i) { return Vec3(after.points[i] - before.points[i]); };
    if (now.kind == geometry::SkeletonKind::triangle) {
        const Vec3 share = shares_on_triangle(at, p);
        return share[0] * way(0) + share[1] * way(1) + share[2] * way(2);
    }
    Vec3 best = way(0);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
        const Vec3 edge = at[i + 1] - at[i];
        const double length_sq = edge.squaredNorm();
        const double t = length_sq > 0 ? std::clamp(edge.dot(p - at[i]) / length_sq, 0.0, 1.0) : 0;
        const double far = (at[i] + t * edge - p).squaredNorm();
        if (!(far < nearest)) continue;
        nearest = far;
        best = (1 - t) * way(i) + t * way(i + 1);
    }
    return best;
}

// Of a share of a length, 0 where the length is.
double share_of(double part, double whole)
{
    return whole > 0 ? std::clamp(part / whole, -1.0, 1.0) : 0;
}

// Of what is round about y, in its own axes.
Vec3 way_of_round(const Skeleton& now, const Skeleton& before, const Skeleton& after, const Vec3& p)
{
    const auto shape = geometry::round_shape(now.kind, now.half_size),
               was = geometry::round_shape(now.kind, before.half_size),
               will = geometry::round_shape(now.kind, after.half_size);
    const double rho = std::hypot(p.x(), p.z());
    const Vec3 out = rho > 0 ? Vec3(p.x() / rho, 0, p.z() / rho) : Vec3(Vec3::Zero());
    if (now.kind == geometry::SkeletonKind::torus) {
        const Vec3 across = (rho - shape.ring) * out + p.y() * Vec3::UnitY();
        const double far = across.norm();
        const Vec3 grown = far > 0 ? Vec3(across / far) : Vec3(Vec3::Zero());
        return (will.ring - was.ring) * out +
               (will.tube - was.tube) * share_of(far, shape.tube) * grown;
    }
    const double up = share_of(p.y(), shape.height);
    const auto radius = [&](const geometry::RoundShape& of) {
        return of.base + (of.top - of.base) * (up + 1) / 2;
    };
    return (radius(will) - radius(was)) * share_of(rho, radius(shape)) * out +
           (will.height - was.height) * up * Vec3::UnitY();
}

}  // namespace

Vec3 way_of(const Skeleton& now, const Skeleton& before, const Skeleton& after, const Vec3& p)
{
    if (geometry::has_points(now.kind)) return way_of_points(now, before, after, p);
    if (before.half_size == after.half_size) return Vec3::Zero();
    if (geometry::is_round(now.kind)) {
        const Vec3 local = now.place.linear().transpose() * (p - now.place.translation());
        return now.place.linear() * way_of_round(now, before, after, local);
    }
    const Vec3 half = geometry::half_extent(now.kind, now.half_size);
    const Vec3 grown = geometry::half_extent(now.kind, after.half_size) -
                       geometry::half_extent(now.kind, before.half_size);
    Vec3 share = now.place.linear().transpose() * (p - now.place.translation());
    for (int k = 0; k < 3; ++k) share[k] = half[k] > 0 ? share[k] / half[k] : 0;
    if (now.kind == geometry::SkeletonKind::box) {
        share = share.cwiseMax(-1.0).cwiseMin(1.0);
    } else if (share.squaredNorm() > 1) {
        share.normalize();
    }
    return now.place.linear() * share.cwiseProduct(grown);
}

Vec3 change_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p)
{
    if (!body.change || !(body.change->seconds > 0) || skeleton >= body.skeletons.size()) {
        return Vec3::Zero();
    }
    const Transform& frame = body.frames[body.frame_of[skeleton]];
    const Vec3 local = frame.linear().transpose() * (p - frame.translation());
    const Vec3 way = way_of(body.skeletons[skeleton], body.change->before[skeleton],
                            body.change->after[skeleton], local);
    return frame.linear() * way / body.change->seconds;
}

Vec3 velocity_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p)
{
    if (body.moving) return velocity_at(*body.moving, p);
    const std::uint32_t f = body.frame_of[skeleton];
    return change_at(body, skeleton, p) + body.twists[f].linear +
           body.twists[f].angular.cross(p - body.frames[f].translation());
}

}  // namespace physics
