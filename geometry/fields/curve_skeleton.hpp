#pragma once

// Curves as skeletons: a Catmull-Rom curve through given positions, as one cubic for each two of
// them.
//
//      p1 .--'--. p2         through the positions, with the centripetal parameter
//       .'       `.          s(i+1) = s(i) + |p(i+1) - p(i)|^(1/2): no cusp and no loop between two
//      p0          p3        positions, however unevenly they are spaced
//
// Catmull, Rom. A class of local interpolating splines. Computer Aided Geometric Design, 1974.
// Yuksel, Schaefer, Keyser. Parameterization and applications of Catmull-Rom curves. Computer-Aided
// Design 43(7), 2011.
//
// Distance from p to a cubic c(t): the nearest of `curve_chords` chords gives t to start from, then
// Newton's steps on (c - p) . c' = 0. The chords stand off the curve by at most `off`, so that a
// cubic whose chords are further than the best so far by more than that is not looked at.

#include "geometry/fields/field_skeleton.hpp"

namespace geometry {

inline constexpr int curve_chords = 16;  // for each cubic
inline constexpr int curve_newton_steps = 4;

// c(t) = ((a t + b) t + c) t + d, 0 <= t <= 1.
struct CurveSpan {
    Vec3 a, b, c, d;
    double off = 0;  // m

    Vec3 at(double t) const { return ((a * t + b) * t + c) * t + d; }
    Vec3 slope(double t) const { return (3 * a * t + 2 * b) * t + c; }
};

// Bezier points of the cubics: 3 for each, and the last end. The curve lies inside their hull. Of
// positions that follow each other at one place, one counts. A curve whose last position is its
// first closes smoothly.
std::vector<Vec3> catmull_rom(std::span<const Vec3> positions);

inline std::size_t curve_span_count(std::span<const Vec3> bezier)
{
    return bezier.size() / 3;
}
CurveSpan curve_span(std::span<const Vec3> bezier, std::size_t i);

Foot foot_on_curve(std::span<const Vec3> bezier, const Vec3& p);

}  // namespace geometry
