#include "geometry/fields/field_skeleton.hpp"

#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace geometry {
namespace {

// About a corner (t zero) or an edge of unit direction t, at offset d from the nearest point.
Foot around(const Vec3& d, const Vec3& t)
{
    Foot foot;
    foot.r = d.norm();
    if (foot.r == 0) return foot;
    foot.n = d / foot.r;
    foot.hessian = (Mat3::Identity() - foot.n * foot.n.transpose() - t * t.transpose()) / foot.r;
    return foot;
}

// Where on the segment from a, 0..1 of ab, p is nearest.
double place_on_segment(const Vec3& a, const Vec3& ab, const Vec3& p)
{
    const double length_sq = ab.squaredNorm();
    return length_sq > 0 ? std::clamp((p - a).dot(ab) / length_sq, 0.0, 1.0) : 0.0;
}

Foot foot_on_segment(const Vec3& a, const Vec3& b, const Vec3& p)
{
    const Vec3 ab = b - a;
    const double length_sq = ab.squaredNorm();
    const double s = place_on_segment(a, ab, p);
    const bool between = s > 0 && s < 1;
    return around(p - (a + s * ab), between ? Vec3(ab / std::sqrt(length_sq)) : Vec3(Vec3::Zero()));
}

}  // namespace

Foot foot_on_polyline(std::span<const Vec3> points, const Vec3& p)
{
    if (points.size() == 1) return around(p - points[0], Vec3::Zero());
    Foot nearest = foot_on_segment(points[0], points[1], p);
    for (std::size_t i = 1; i + 1 < points.size(); ++i) {
        const Foot foot = foot_on_segment(points[i], points[i + 1], p);
        if (foot.r < nearest.r) nearest = foot;
    }
    return nearest;
}

double distance_to_polyline(std::span<const Vec3> points, const Vec3& p)
{
    if (points.size() == 1) return (p - points[0]).norm();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        const Vec3 ab = points[i + 1] - points[i];
        const double s = place_on_segment(points[i], ab, p);
        nearest = std::min(nearest, (p - (points[i] + s * ab)).norm());
    }
    return nearest;
}

Foot foot_on_triangle(std::span<const Vec3, 3> corners, const Vec3& p)
{
    const Vec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
    const Vec3 normal = ab.cross(ac);
    const double area_sq = normal.squaredNorm();
    const double scale = std::max(ab.squaredNorm(), ac.squaredNorm());
    if (area_sq > 1e-24 * scale * scale) {
        // Barycentric coordinates of the projection: inside, the face is nearest.
        const Vec3 ap = p - corners[0];
        const double v = ap.cross(ac).dot(normal), w = ab.cross(ap).dot(normal);
        if (v > 0 && w > 0 && v + w < area_sq) {
            const Vec3 unit = normal / std::sqrt(area_sq);
            const double height = ap.dot(unit);
            if (height == 0) return {};
            return {std::abs(height), height > 0 ? unit : Vec3(-unit), Mat3::Zero()};
        }
    }
    const Vec3 loop[] = {corners[0], corners[1], corners[2], corners[0]};
    return foot_on_polyline(loop, p);
}

Foot foot_on_box(const Vec3& half_size, const Vec3& p)
{
    const Vec3 beyond = p.cwiseAbs() - half_size;
    const Vec3 sign = p.unaryExpr([](double x) { return x < 0 ? -1.0 : 1.0; });
    if ((beyond.array() <= 0).all()) {
        Foot inside;
        Eigen::Index axis = 0;
        inside.r = beyond.maxCoeff(&axis);
        inside.n = sign[axis] * Vec3::Unit(axis);
        return inside;
    }
    const Vec3 d = beyond.cwiseMax(0.0).cwiseProduct(sign);
    const int outside = static_cast<int>((beyond.array() > 0).count());
    Vec3 t = Vec3::Zero();
    if (outside == 2) {
        for (int axis = 0; axis < 3; ++axis) {
            if (beyond[axis] <= 0) t[axis] = 1;
        }
    }
    Foot foot = around(d, t);
    if (outside == 1) foot.hessian.setZero();
    return foot;
}

// The nearest point q solves p = q + t q / a^2 componentwise, with q on the ellipsoid:
//   F(t) = sum (a_i p_i / (a_i^2 + t))^2 - 1 = 0,  t > -min a^2.
// F is convex and decreasing there, and at t0 = max(a_i |p_i| - a_i^2) one term alone is 1, so
// F(t0) >= 0 and Newton's steps from t0 grow towards the root without passing it.
// Eberly, D. Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid. 2013.
Foot foot_on_ellipsoid(const Vec3& semi_axes, const Vec3& p)
{
    const Vec3 a_sq = semi_axes.cwiseAbs2();
    Eigen::Index least = 0;
    semi_axes.minCoeff(&least);

    Vec3 q;
    // On the plane across the least axis, far enough inside, the nearest point lies off that plane:
    // there t = -min a^2 and the least axis takes what the others leave.
    const double t_min = -a_sq[least];
    double others = 0;
    for (int i = 0; i < 3; ++i) {
        if (a_sq[i] == a_sq[least]) continue;
        const double term = semi_axes[i] * p[i] / (a_sq[i] + t_min);
        others += term * term;
    }
    bool on_axis_plane = true;  // all coordinates along axes as short as the least are zero
    for (int i = 0; i < 3; ++i) {
        on_axis_plane &= a_sq[i] != a_sq[least] || std::abs(p[i]) < 1e-14 * semi_axes[least];
    }
    if (on_axis_plane && others < 1) {
        for (int i = 0; i < 3; ++i) {
            q[i] = a_sq[i] == a_sq[least] ? 0 : a_sq[i] * p[i] / (a_sq[i] + t_min);
        }
        q[least] = (p[least] < 0 ? -1 : 1) * semi_axes[least] * std::sqrt(1 - others);
    } else {
        double t = (semi_axes.cwiseProduct(p.cwiseAbs()) - a_sq).maxCoeff();
        for (int iteration = 0; iteration < 100; ++iteration) {
            double value = -1, slope = 0;
            for (int i = 0; i < 3; ++i) {
                const double denominator = a_sq[i] + t;
                if (p[i] == 0) continue;
                const double term = semi_axes[i] * p[i] / denominator;
                value += term * term;
                slope -= 2 * term * term / denominator;
            }
            const double next = t - value / slope;
            if (!(next > t)) break;  // as near as doubles go
            t = next;
        }
        for (int i = 0; i < 3; ++i) q[i] = p[i] == 0 ? 0 : a_sq[i] * p[i] / (a_sq[i] + t);
    }

    const Vec3 w = q.cwiseQuotient(a_sq);
    const double w_norm = w.norm();
    Foot foot;
    foot.n = w / w_norm;
    foot.r = (p - q).dot(foot.n);
    const Mat3 tangent = Mat3::Identity() - foot.n * foot.n.transpose();
    const Mat3 shape = tangent * a_sq.cwiseInverse().asDiagonal() * tangent / w_norm;
    foot.hessian = (Mat3::Identity() + foot.r * shape).inverse() * shape;
    return foot;
}

Foot foot_on_plane(const Vec3& p)
{
    return {p.y(), Vec3::UnitY(), Mat3::Zero()};
}

namespace {

// By the point of the mesh nearest to p; as if it had no inside.
Foot foot_at(const SkeletonMesh& mesh, const TriangleBvh::Hit& hit, const Vec3& p)
{
    if (!hit) return {std::numeric_limits<double>::infinity(), Vec3::Zero(), Mat3::Zero()};
    Vec3 t = Vec3::Zero();
    int inner = 0, across = 0;  // of how many corners the point is a mixture
    for (int i = 0; i < 3; ++i) {
        if (hit.barycentric[i] > 0)
            ++inner;
        else
            across = i;
    }
    if (inner == 2) {
        const auto corner = [&](int i) {
            const auto v = mesh.mesh.triangles()[hit.triangle][static_cast<std::size_t>(i % 3)];
            return Vec3(mesh.mesh.positions[v].cast<double>());
        };
        t = (corner(across + 2) - corner(across + 1)).normalized();
    }
    Foot foot = around(p - hit.point, t);
    if (inner == 3) foot.hessian.setZero();
    return foot;
}

}  // namespace

Foot foot_on_mesh(const SkeletonMesh& mesh, const Vec3& p)
{
    const TriangleBvh::Hit hit = mesh.tree.closest(p);
    Foot foot = foot_at(mesh, hit, p);
    if (!hit) return foot;
    if (foot.r == 0) foot.n = hit.normal;
    if (hit.behind) {
        foot.r = -foot.r;
        foot.n = -foot.n;
        foot.hessian = -foot.hessian;
    }
    return foot;
}

Foot foot_on_sheet(const SkeletonMesh& mesh, const Vec3& p)
{
    return foot_at(mesh, mesh.tree.closest(p), p);
}

FieldStretch stretch_of(const Skeleton& skeleton, const Mat3& turn)
{
    if (!skeleton.stretches()) return {};
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(skeleton.stretch);
    const Mat3 axes = turn * eigen.eigenvectors();
    const Vec3& along = eigen.eigenvalues();
    return {axes * along.asDiagonal() * axes.transpose(),
            axes * along.cwiseInverse().asDiagonal() * axes.transpose(), along.maxCoeff()};
}

bool is_rigid(const Transform& transform)
{
    const Mat3 r = transform.linear();
    return transform.matrix().allFinite() &&
           (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-6 &&
           r.determinant() > 0;
}

namespace {

void check_stretch(const Skeleton& s, const char* what)
{
    if (!s.stretches()) return;
    constexpr double rounding = 1e-9;
    const Mat3& a = s.stretch;
    const bool symmetric = a.allFinite() && (a - a.transpose()).norm() <= rounding * a.norm();
    const double least =
        symmetric ? Eigen::SelfAdjointEigenSolver<Mat3>(a, Eigen::EigenvaluesOnly).eigenvalues()[0]
                  : 0;
    if (least >= 1 - rounding) return;
    throw std::invalid_argument(fmt::format(
        "the stretch of a {} skeleton must be {}. Give the least thickness as `thickness`, and how "
        "many times as thick it is elsewhere as `stretch`",
        what,
        symmetric ? fmt::format("1 or more along each axis, got {:g} along one", least)
                  : "a symmetric matrix of finite numbers"));
}

void check_points(const Skeleton& s, std::size_t least, std::size_t most, const char* what)
{
    if (s.points.size() < least || s.points.size() > most) {
        throw std::invalid_argument(fmt::format("a {} skeleton needs {}{} point{}, got {}", what,
                                                least, most > least ? " or more" : "",
                                                most > 1 ? "s" : "", s.points.size()));
    }
    check_stretch(s, what);
    for (const Vec3& p : s.points) {
        if (!p.allFinite()) {
            throw std::invalid_argument(
                fmt::format("a {} skeleton has a point that is not finite", what));
        }
    }
}

void check_round(const Skeleton& s)
{
    const Vec3& half = s.half_size;
    const bool torus = s.kind == SkeletonKind::torus, cone = s.kind == SkeletonKind::cone;
    if (torus && !(half.y() >= 0 && half.x() > 0 && half.x() >= 2 * half.y())) {
        throw std::invalid_argument(
            fmt::format("a torus skeleton needs an outer width (x) of at least twice its thickness "
                        "(y, 0 or above), got {} and {}",
                        2 * half.x(), 2 * half.y()));
    }
    if (!torus && !(half.x() > 0 && half.y() > 0 && (!cone || half.z() >= 0))) {
        throw std::invalid_argument(fmt::format(
            "a {} skeleton needs a width (x) and a height (y) above 0{}, got {}, {} "
            "and {}",
            cone ? "cone" : "cylinder", cone ? ", and at its top a width (z) from 0" : "",
            2 * half.x(), 2 * half.y(), 2 * half.z()));
    }
}

// What a solid or a sheet is made of.
void check_size(const Skeleton& s)
{
    const bool of_mesh = s.kind == SkeletonKind::mesh || s.kind == SkeletonKind::sheet;
    if (of_mesh && (!s.mesh || s.mesh->tree.triangle_count() == 0)) {
        throw std::invalid_argument("a mesh skeleton needs a mesh with triangles, got none");
    }
    if (of_mesh || s.kind == SkeletonKind::plane) return;
    const bool box = s.kind == SkeletonKind::box || s.kind == SkeletonKind::ellipsoid;
    if (!s.half_size.allFinite() || (box && (s.half_size.array() <= 0).any())) {
        throw std::invalid_argument(
            fmt::format("a box or ellipsoid skeleton needs a size above 0 along each axis, got "
                        "half sizes {} {} {}",
                        s.half_size.x(), s.half_size.y(), s.half_size.z()));
    }
    if (!box) check_round(s);
}

}  // namespace

void check(const Skeleton& s)
{
    switch (s.kind) {
    case SkeletonKind::point:
        return check_points(s, 1, 1, "point");
    case SkeletonKind::segment:
        return check_points(s, 2, 2, "segment");
    case SkeletonKind::polyline:
        return check_points(s, 2, 1 << 20, "polyline");
    case SkeletonKind::curve:
        return check_points(s, 2, 1 << 20, "curve");
    case SkeletonKind::triangle:
        return check_points(s, 3, 3, "triangle");
    default:
        check_size(s);
        if (!is_rigid(s.place)) {
            throw std::invalid_argument("the place of a solid skeleton must be rigid; change its "
                                        "size instead of scaling it");
        }
        if (s.stretches()) {
            throw std::invalid_argument(
                "only skeletons drawn by points (point, segment, polyline, triangle, curve) have a "
                "stretch; change the size of a solid instead");
        }
    }
}

}  // namespace geometry
