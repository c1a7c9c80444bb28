#include "physics/body/four_points.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr double beyond = 0.01;  // of a side: neighbours overlap by as much

// A share of an edge or of a triangle with few enough digits that sums of them have no rounding,
// so that forces on the four points add up to nothing.
double rounded(double share)
{
    constexpr double digits = 1 << 20;
    return std::round(share * digits) / digits;
}

bool within(double share)
{
    return share >= -beyond && share <= 1 + beyond;
}

std::optional<Stand> stand_of_point(const FourPoints& x)
{
    const Vec3 u = x[2] - x[1], v = x[3] - x[1], p = x[0] - x[1];
    const Vec3 n = u.cross(v);
    const double area_sq = n.squaredNorm();
    if (!(area_sq > 1e-12 * u.squaredNorm() * v.squaredNorm())) return std::nullopt;
    const double s = rounded(p.cross(v).dot(n) / area_sq), t = rounded(u.cross(p).dot(n) / area_sq);
    if (!within(s) || !within(t) || !within(1 - s - t)) return std::nullopt;
    const Vec3 normal = n / std::sqrt(area_sq);
    return Stand{{1, -(1 - s - t), -s, -t}, normal, p.dot(normal)};
}

std::optional<Stand> stand_of_edges(const FourPoints& x)
{
    const Vec3 u = x[1] - x[0], v = x[3] - x[2], p = x[2] - x[0];
    const Vec3 n = u.cross(v);
    const double area_sq = n.squaredNorm();
    if (!(area_sq > 1e-6 * u.squaredNorm() * v.squaredNorm())) return std::nullopt;
    const double s = rounded(p.cross(v).dot(n) / area_sq), t = rounded(p.cross(u).dot(n) / area_sq);
    if (!within(s) || !within(t)) return std::nullopt;
    const Vec3 normal = n / std::sqrt(area_sq);
    return Stand{{1 - s, s, -(1 - t), -t}, normal, -p.dot(normal)};
}

// c0 + c1 t + c2 t^2 + c3 t^3
struct Cubic {
    std::array<double, 4> c;

    double at(double t) const { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); }
};

// Where it changes its sign between lo and hi, in between which it rises or falls throughout.
double root_between(const Cubic& cubic, double lo, double hi)
{
    const bool rises = cubic.at(hi) > 0;
    for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (lo + hi);
        ((cubic.at(middle) > 0) == rises ? hi : lo) = middle;
    }
    return hi;
}

}  // namespace

std::optional<Stand> stand_of(Four kind, const FourPoints& x)
{
    return kind == Four::point ? stand_of_point(x) : stand_of_edges(x);
}

PlaneTimes plane_times(const FourPoints& a, const FourPoints& b)
{
    // The volume of sides u, v and w from the first point, each p + t q.
    std::array<Vec3, 3> p, q;
    for (std::size_t i = 0; i < 3; ++i) {
        p[i] = a[i + 1] - a[0];
        q[i] = b[i + 1] - b[0] - p[i];
    }
    const Vec3 pp = p[0].cross(p[1]), pq = p[0].cross(q[1]) + q[0].cross(p[1]);
    const Vec3 qq = q[0].cross(q[1]);
    const Cubic cubic{
        {pp.dot(p[2]), pp.dot(q[2]) + pq.dot(p[2]), pq.dot(q[2]) + qq.dot(p[2]), qq.dot(q[2])}};
    // It rises or falls throughout between these.
    std::array<double, 4> turn{0, 1, 1, 1};
    std::size_t turns = 1;
    const double third = 3 * cubic.c[3], half = cubic.c[2], less = cubic.c[1];
    const double root_sq = half * half - third * less;
    if (root_sq >= 0) {
        const double sum = -(half + std::copysign(std::sqrt(root_sq), half));
        std::array<double, 2> at{third != 0 ? sum / third : -1, sum != 0 ? less / sum : -1};
        std::sort(at.begin(), at.end());
        for (const double t : at) {
            if (t > 0 && t < 1) turn[turns++] = t;
        }
    }
    turn[turns] = 1;
    PlaneTimes out;
    for (std::size_t i = 0; i < turns; ++i) {
        const double from = cubic.at(turn[i]), to = cubic.at(turn[i + 1]);
        if ((from > 0 && to <= 0) || (from < 0 && to >= 0)) {
            out.at[out.count++] = root_between(cubic, turn[i], turn[i + 1]);
        }
    }
    return out;
}

std::optional<Stand> meeting_of(Four kind, const FourPoints& a, const FourPoints& b)
{
    const PlaneTimes times = plane_times(a, b);
    for (std::size_t i = 0; i < times.count; ++i) {
        FourPoints x;
        for (std::size_t k = 0; k < 4; ++k) x[k] = a[k] + times.at[i] * (b[k] - a[k]);
        if (auto stand = stand_of(kind, x)) return stand;
    }
    return std::nullopt;
}

Stand turned_to(Stand stand, const Vec3& way)
{
    if (stand.normal.dot(way) < 0) stand.normal = -stand.normal, stand.distance = -stand.distance;
    return stand;
}

}  // namespace physics
