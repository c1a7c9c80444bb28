#include "geometry/fields/curve_skeleton.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

// Slope of the curve at b, per unit of the parameter, between a and c; by Barry and Goldman's
// pyramid, whose slope at an inner knot is this mean of the neighbouring differences.
Vec3 slope_at(const Vec3& a, const Vec3& b, const Vec3& c, double before, double after)
{
    return (b - a) / before - (c - a) / (before + after) + (c - b) / after;
}

// The parameter's length from one position to the next.
double knot(const Vec3& a, const Vec3& b)
{
    return std::sqrt((b - a).norm());
}

// Where along the chords of a span p is nearest: t and the squared distance.
struct ChordFoot {
    double t = 0, r_sq = 1e300;
};

ChordFoot nearest_chord(const CurveSpan& span, const Vec3& p)
{
    ChordFoot best;
    for (int j = 0; j < curve_chords; ++j) {
        const Vec3 from = span.at(double(j) / curve_chords);
        const Vec3 along = span.at(double(j + 1) / curve_chords) - from;
        const double length_sq = along.squaredNorm();
        const double s =
            std::clamp((p - from).dot(along) / (length_sq > 0 ? length_sq : 1.0), 0.0, 1.0);
        const double r_sq = (p - from - s * along).squaredNorm();
        if (r_sq < best.r_sq) best = {(j + s) / curve_chords, r_sq};
    }
    return best;
}

double refined(const CurveSpan& span, const Vec3& p, double t)
{
    for (int i = 0; i < curve_newton_steps; ++i) {
        const Vec3 off = span.at(t) - p, slope = span.slope(t), bend = 6 * span.a * t + 2 * span.b;
        const double speed_sq = slope.squaredNorm();
        const double full = speed_sq + off.dot(bend);
        // Past the centre of curvature the full second derivative is not positive.
        const double second = full > 0.1 * speed_sq ? full : speed_sq;
        if (!(second > 0)) break;
        t = std::clamp(t - off.dot(slope) / second, 0.0, 1.0);
    }
    return t;
}

}  // namespace

std::vector<Vec3> catmull_rom(std::span<const Vec3> positions)
{
    std::vector<Vec3> p;
    for (const Vec3& x : positions) {
        if (p.empty() || x != p.back()) p.push_back(x);
    }
    if (p.size() < 2) return std::vector<Vec3>(4, p.empty() ? Vec3(Vec3::Zero()) : p[0]);
    const bool closed = p.size() > 3 && p.front() == p.back();
    const std::size_t spans = p.size() - 1;

    // Slopes at the positions. An open curve ends straight towards its neighbour's slope: the
    // parabola through the last two positions with that slope.
    std::vector<Vec3> slope(p.size());
    for (std::size_t i = 1; i < spans; ++i) {
        slope[i] = slope_at(p[i - 1], p[i], p[i + 1], knot(p[i - 1], p[i]), knot(p[i], p[i + 1]));
    }
    const double first = knot(p[0], p[1]), last = knot(p[spans - 1], p[spans]);
    if (closed) {
        slope[0] = slope[spans] = slope_at(p[spans - 1], p[0], p[1], last, first);
    } else if (spans == 1) {
        slope[0] = slope[1] = (p[1] - p[0]) / first;
    } else {
        slope[0] = 2 * (p[1] - p[0]) / first - slope[1];
        slope[spans] = 2 * (p[spans] - p[spans - 1]) / last - slope[spans - 1];
    }
    std::vector<Vec3> bezier;
    bezier.reserve(3 * spans + 1);
    for (std::size_t i = 0; i < spans; ++i) {
        const double third = knot(p[i], p[i + 1]) / 3;
        bezier.push_back(p[i]);
        bezier.push_back(p[i] + third * slope[i]);
        bezier.push_back(p[i + 1] - third * slope[i + 1]);
    }
    bezier.push_back(p[spans]);
    return bezier;
}

CurveSpan curve_span(std::span<const Vec3> bezier, std::size_t i)
{
    const Vec3 &p0 = bezier[3 * i], &p1 = bezier[3 * i + 1], &p2 = bezier[3 * i + 2],
               &p3 = bezier[3 * i + 3];
    const Vec3 bend_0 = p0 - 2 * p1 + p2, bend_1 = p1 - 2 * p2 + p3;
    // A chord over h of the parameter is off by at most h^2 / 8 times the largest |c''|.
    const double most = 6 * std::sqrt(std::max(bend_0.squaredNorm(), bend_1.squaredNorm()));
    return {p3 - p0 + 3 * (p1 - p2), 3 * bend_0, 3 * (p1 - p0), p0,
            most / (8.0 * curve_chords * curve_chords)};
}

Foot foot_on_curve(std::span<const Vec3> bezier, const Vec3& p)
{
    const std::size_t spans = curve_span_count(bezier);
    Foot foot;
    foot.r = 1e300;
    double t = 0;
    std::size_t nearest = 0;
    Vec3 d = Vec3::Zero();
    for (std::size_t i = 0; i < spans; ++i) {
        const CurveSpan span = curve_span(bezier, i);
        const ChordFoot chord = nearest_chord(span, p);
        if (!(std::sqrt(chord.r_sq) - span.off < foot.r)) continue;
        const double at = refined(span, p, chord.t);
        const Vec3 off = p - span.at(at);
        if (!(off.norm() < foot.r)) continue;
        foot.r = off.norm();
        d = off;
        t = at;
        nearest = i;
    }
    if (foot.r == 0) return foot;
    foot.n = d / foot.r;
    const CurveSpan span = curve_span(bezier, nearest);
    const Vec3 slope = span.slope(t);
    const double speed_sq = slope.squaredNorm();
    foot.hessian = (Mat3::Identity() - foot.n * foot.n.transpose()) / foot.r;
    const bool open_end = bezier.front() != bezier.back() &&
                          ((t == 0 && nearest == 0) || (t == 1 && nearest + 1 == spans));
    if (open_end || !(speed_sq > 0)) return foot;
    // Along the curve, of curvature k towards p, r grows by -k / (1 - r k).
    const double k = foot.n.dot(6 * span.a * t + 2 * span.b) / speed_sq;
    const Mat3 along = slope * slope.transpose() / speed_sq;
    foot.hessian -= along * (1 / foot.r + k / (1 - foot.r * k));
    return foot;
}

}  // namespace geometry
