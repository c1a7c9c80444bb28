#include "geometry/fields/round_skeleton.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

// From the half plane into space: gradient (n_rho, n_y), and curvature `bend` of the distance's
// level lines there. About the axis a level surface has the curvature n_rho / rho.
Foot turned_about_y(double r, double n_rho, double n_y, double bend, const Vec3& p)
{
    const double rho = std::hypot(p.x(), p.z());
    const Vec3 out = rho > 0 ? Vec3(p.x() / rho, 0, p.z() / rho) : Vec3(Vec3::UnitX());
    const Vec3 round = out.cross(Vec3::UnitY());
    const Vec3 along = n_rho * Vec3::UnitY() - n_y * out;
    Foot foot;
    foot.r = r;
    foot.n = n_rho * out + n_y * Vec3::UnitY();
    const double about = rho > 0 ? n_rho / rho : bend;
    foot.hessian = bend * along * along.transpose() + about * round * round.transpose();
    return foot;
}

}  // namespace

RoundShape round_shape(SkeletonKind kind, const Vec3& half_size)
{
    RoundShape shape;
    if (kind == SkeletonKind::torus) {
        shape.ring = half_size.x() - half_size.y();
        shape.tube = half_size.y();
        return shape;
    }
    shape.base = half_size.x();
    shape.top = kind == SkeletonKind::cone ? half_size.z() : half_size.x();
    shape.height = half_size.y();
    return shape;
}

Vec3 half_extent(SkeletonKind kind, const Vec3& half_size)
{
    if (!is_round(kind)) return half_size;
    const double out =
        kind == SkeletonKind::cone ? std::max(half_size.x(), half_size.z()) : half_size.x();
    return {out, half_size.y(), out};
}

Foot foot_on_torus(const RoundShape& shape, const Vec3& p)
{
    const double out = std::sqrt(p.x() * p.x() + p.z() * p.z()) - shape.ring;
    const double q = std::sqrt(out * out + p.y() * p.y());
    if (q == 0) return {-shape.tube, Vec3::Zero(), Mat3::Zero()};
    return turned_about_y(q - shape.tube, out / q, p.y() / q, 1 / q, p);
}

Foot foot_on_cone(const RoundShape& shape, const Vec3& p)
{
    const double rho = std::sqrt(p.x() * p.x() + p.z() * p.z());
    const double up = p.y() < 0 ? -1 : 1;
    // To the nearer of the two flat ends, and to the slope between them.
    const double cap_rho = std::max(rho - (p.y() < 0 ? shape.base : shape.top), 0.0);
    const double cap_y = up * p.y() - shape.height;
    const double in = shape.base - shape.top, tall = 2 * shape.height;
    const double length_sq = in * in + tall * tall;
    const double s =
        std::clamp(((rho - shape.top) * in + (shape.height - p.y()) * tall) / length_sq, 0.0, 1.0);
    const double side_rho = rho - shape.top - in * s, side_y = p.y() - shape.height + tall * s;
    const bool inside = side_rho < 0 && cap_y < 0;
    const double cap_sq = cap_rho * cap_rho + cap_y * cap_y;
    const double side_sq = side_rho * side_rho + side_y * side_y;
    const double sign = inside ? -1 : 1;
    if (cap_sq < side_sq) {
        const double q = std::sqrt(cap_sq);
        if (q == 0) return turned_about_y(0, 0, up, 0, p);
        const double bend = cap_rho > 0 ? 1 / q : 0;
        return turned_about_y(sign * q, sign * cap_rho / q, sign * up * cap_y / q, bend, p);
    }
    const double q = std::sqrt(side_sq), length = std::sqrt(length_sq);
    if (q == 0) return turned_about_y(0, tall / length, in / length, 0, p);
    const double bend = s > 0 && s < 1 ? 0 : sign / q;
    return turned_about_y(sign * q, sign * side_rho / q, sign * side_y / q, bend, p);
}

}  // namespace geometry
