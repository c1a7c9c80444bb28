#pragma once

// The closest point of a triangle to the origin, and on which of its parts it lies.
// Ericson. Real-time collision detection. Morgan Kaufmann 2005, 5.1.5.

#include "geometry/base/vec.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace geometry {

struct OnTriangle {
    enum Feature : std::uint8_t { face, side_ab, side_bc, side_ca, corner_a, corner_b, corner_c };

    Vec3 barycentric;
    Feature feature;
};

// The closest point to the origin of the segment from a to b, as its share of b.
inline double along_segment(const Vec3& a, const Vec3& b)
{
    const Vec3 d = b - a;
    const double length_sq = d.squaredNorm();
    return length_sq > 0 ? std::clamp(-a.dot(d) / length_sq, 0.0, 1.0) : 0.0;
}

// The closest point of triangle abc to the origin, by its sides only: for one without area.
inline OnTriangle on_sides(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const std::array<const Vec3*, 3> corner{&a, &b, &c};
    double best_sq = std::numeric_limits<double>::infinity();
    OnTriangle best{};
    for (std::size_t s = 0; s < 3; ++s) {
        const std::size_t e = (s + 1) % 3;
        const double t = along_segment(*corner[s], *corner[e]);
        const double d_sq = ((1 - t) * *corner[s] + t * *corner[e]).squaredNorm();
        if (!(d_sq < best_sq)) continue;
        best_sq = d_sq;
        best.barycentric = Vec3::Zero();
        best.barycentric[static_cast<Eigen::Index>(s)] = 1 - t;
        best.barycentric[static_cast<Eigen::Index>(e)] = t;
        best.feature = static_cast<OnTriangle::Feature>(t <= 0   ? OnTriangle::corner_a + s
                                                        : t >= 1 ? OnTriangle::corner_a + e
                                                                 : OnTriangle::side_ab + s);
    }
    return best;
}

// The closest point of triangle abc to the origin.
inline OnTriangle on_triangle(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3 ab = b - a, ac = c - a;
    const double d1 = -ab.dot(a), d2 = -ac.dot(a);
    if (d1 <= 0 && d2 <= 0) return {{1, 0, 0}, OnTriangle::corner_a};
    const double d3 = -ab.dot(b), d4 = -ac.dot(b);
    if (d3 >= 0 && d4 <= d3) return {{0, 1, 0}, OnTriangle::corner_b};
    const double d5 = -ab.dot(c), d6 = -ac.dot(c);
    if (d6 >= 0 && d5 <= d6) return {{0, 0, 1}, OnTriangle::corner_c};

    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) {
        const double t = d1 / (d1 - d3);
        return {{1 - t, t, 0}, OnTriangle::side_ab};
    }
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) {
        const double t = d2 / (d2 - d6);
        return {{1 - t, 0, t}, OnTriangle::side_ca};
    }
    const double va = d3 * d6 - d5 * d4;
    const double bc = d4 - d3, cb = d5 - d6;
    if (va <= 0 && bc >= 0 && cb >= 0 && bc + cb > 0) {
        const double t = bc / (bc + cb);
        return {{0, 1 - t, t}, OnTriangle::side_bc};
    }
    const double sum = va + vb + vc;
    // A needle's area drowns in rounding: then its sides are the triangle.
    const double scale = ab.squaredNorm() * ac.squaredNorm();
    if (!(sum > 1e-20 * scale)) return on_sides(a, b, c);
    return {{va / sum, vb / sum, vc / sum}, OnTriangle::face};
}

}  // namespace geometry
