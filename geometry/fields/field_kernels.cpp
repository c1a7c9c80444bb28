#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geometry/fields/field_kernels.cpp"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set

#include "geometry/fields/field_kernels.hpp"

#include "geometry/fields/curve_skeleton.hpp"
#include "geometry/fields/round_skeleton.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace geometry::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<double>;
using V = hn::Vec<D>;

// Steps of one vector over the points; blocks are padded to a multiple of 8 lanes.
template <class Body> HWY_INLINE void for_lanes(std::size_t count, const Body& body)
{
    const D d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) body(i);
}

struct Spread {  // a FieldProfile in every lane
    explicit Spread(const FieldProfile& p)
        : e(hn::Set(D(), p.e)), R(hn::Set(D(), p.R)), c(hn::Set(D(), p.c)), k(hn::Set(D(), p.k)),
          q(hn::Set(D(), p.q)), q2(hn::Set(D(), p.q + p.q)), m(hn::Set(D(), p.m)),
          inverse(hn::Set(D(), p.inverse)), c2(hn::Set(D(), 2 * p.c))
    {}
    V e, R, c, k, q, q2, m, inverse, c2;
};

// As profile_at(), the same operations in the same order.
HWY_INLINE void profile(const Spread& p, V r, V& f, V& slope)
{
    const D d;
    const V one = hn::Set(d, 1.0), two = hn::Set(d, 2.0), three = hn::Set(d, 3.0);
    const V depth = p.e - r;
    const V f_in = p.c + depth * (p.k + p.q * depth);
    const V slope_in = hn::Neg(p.k + p.q2 * depth);
    const V u = (p.R - r) * p.inverse;
    const V f_out = u * u * (p.c + p.m * (one - u));
    const V slope_out = hn::Neg(p.inverse) * u * (p.c2 + p.m * (two - three * u));
    const auto inside = hn::Ge(depth, hn::Zero(d));
    const auto near = hn::Lt(r, p.R);
    f = hn::IfThenElseZero(near, hn::IfThenElse(inside, f_in, f_out));
    slope = hn::IfThenElseZero(near, hn::IfThenElse(inside, slope_in, slope_out));
}

HWY_INLINE void add(double* to, V what)
{
    const D d;
    hn::Store(hn::Load(d, to) + what, d, to);
}

// foot(i, dx, dy, dz): offset from the nearest point of the skeleton; its length is r.
template <class Offset>
HWY_INLINE void add_offsets(const FieldProfile& p, const FieldBlock& block, BlockValues& sum,
                            const Offset& offset)
{
    const Spread spread(p);
    const V zero = hn::Zero(D()), one = hn::Set(D(), 1.0);
    for_lanes(block.count, [&](std::size_t i) HWY_ATTR {
        V dx, dy, dz, f, slope;
        offset(i, dx, dy, dz);
        const V r = hn::Sqrt(dx * dx + dy * dy + dz * dz);
        if (hn::AllFalse(D(), hn::Lt(r, spread.R))) return;
        profile(spread, r, f, slope);
        const V w = slope / hn::IfThenElse(hn::Gt(r, zero), r, one);
        add(sum.f + i, f);
        add(sum.gx + i, w * dx);
        add(sum.gy + i, w * dy);
        add(sum.gz + i, w * dz);
    });
}

void AddPoint(const Vec3& centre, const FieldProfile& p, const FieldBlock& block, BlockValues& sum)
{
    const D d;
    const V cx = hn::Set(d, centre.x()), cy = hn::Set(d, centre.y()), cz = hn::Set(d, centre.z());
    add_offsets(p, block, sum, [&](std::size_t i, V& dx, V& dy, V& dz) HWY_ATTR {
        dx = hn::Load(d, block.x + i) - cx;
        dy = hn::Load(d, block.y + i) - cy;
        dz = hn::Load(d, block.z + i) - cz;
    });
}

void AddPolyline(const Vec3* points, std::size_t count, const FieldProfile& p,
                 const FieldBlock& block, BlockValues& sum)
{
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0);
    add_offsets(p, block, sum, [&](std::size_t i, V& dx, V& dy, V& dz) HWY_ATTR {
        const V px = hn::Load(d, block.x + i), py = hn::Load(d, block.y + i),
                pz = hn::Load(d, block.z + i);
        V nearest = hn::Set(d, 1e300);
        dx = hn::Set(d, 1e150);
        dy = dz = zero;
        for (std::size_t s = 0; s + 1 < count; ++s) {
            const Vec3& a = points[s];
            const Vec3 ab = points[s + 1] - a;
            const double length_sq = ab.squaredNorm();
            const V ux = hn::Set(d, ab.x()), uy = hn::Set(d, ab.y()), uz = hn::Set(d, ab.z());
            const V ex = px - hn::Set(d, a.x()), ey = py - hn::Set(d, a.y()),
                    ez = pz - hn::Set(d, a.z());
            V t = (ex * ux + ey * uy + ez * uz) / hn::Set(d, length_sq > 0 ? length_sq : 1.0);
            t = hn::Min(hn::Max(t, zero), one);
            const V ox = ex - t * ux, oy = ey - t * uy, oz = ez - t * uz;
            const V r_sq = ox * ox + oy * oy + oz * oz;
            const auto closer = hn::Lt(r_sq, nearest);
            nearest = hn::IfThenElse(closer, r_sq, nearest);
            dx = hn::IfThenElse(closer, ox, dx);
            dy = hn::IfThenElse(closer, oy, dy);
            dz = hn::IfThenElse(closer, oz, dz);
        }
    });
}

struct Vec3V {
    V x, y, z;
};

HWY_INLINE Vec3V spread(const Vec3& v)
{
    const D d;
    return {hn::Set(d, v.x()), hn::Set(d, v.y()), hn::Set(d, v.z())};
}

HWY_INLINE V dot(const Vec3V& a, const Vec3V& b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

HWY_INLINE V clamped(V t)
{
    return hn::Min(hn::Max(t, hn::Zero(D())), hn::Set(D(), 1.0));
}

// Points of a curve's span from its coefficients in every lane.
struct SpanV {
    explicit SpanV(const CurveSpan& s)
        : a(spread(s.a)), b(spread(s.b)), c(spread(s.c)), d(spread(s.d))
    {}
    HWY_INLINE Vec3V at(V t) const
    {
        return {((a.x * t + b.x) * t + c.x) * t + d.x, ((a.y * t + b.y) * t + c.y) * t + d.y,
                ((a.z * t + b.z) * t + c.z) * t + d.z};
    }
    HWY_INLINE Vec3V slope(V t) const
    {
        const V three = hn::Set(D(), 3.0), two = hn::Set(D(), 2.0);
        return {(three * a.x * t + two * b.x) * t + c.x, (three * a.y * t + two * b.y) * t + c.y,
                (three * a.z * t + two * b.z) * t + c.z};
    }
    HWY_INLINE Vec3V bend(V t) const
    {
        const V six = hn::Set(D(), 6.0), two = hn::Set(D(), 2.0);
        return {six * a.x * t + two * b.x, six * a.y * t + two * b.y, six * a.z * t + two * b.z};
    }
    Vec3V a, b, c, d;
};

// As nearest_chord() in curve_skeleton.cpp: t, and the squared distance.
HWY_INLINE V nearest_chord(const CurveSpan& span, const Vec3V& p, V& nearest_sq)
{
    const D d;
    V t = hn::Zero(d);
    nearest_sq = hn::Set(d, 1e300);
    Vec3 from = span.at(0);
    for (int j = 0; j < curve_chords; ++j) {
        const Vec3 to = span.at(double(j + 1) / curve_chords);
        const Vec3 along = to - from;
        const double length_sq = along.squaredNorm();
        const Vec3V u = spread(along), start = spread(from);
        const Vec3V e{p.x - start.x, p.y - start.y, p.z - start.z};
        const V s = clamped(dot(e, u) / hn::Set(d, length_sq > 0 ? length_sq : 1.0));
        const Vec3V o{e.x - s * u.x, e.y - s * u.y, e.z - s * u.z};
        const V r_sq = dot(o, o);
        const auto closer = hn::Lt(r_sq, nearest_sq);
        nearest_sq = hn::IfThenElse(closer, r_sq, nearest_sq);
        t = hn::IfThenElse(closer, (hn::Set(d, j) + s) / hn::Set(d, curve_chords), t);
        from = to;
    }
    return t;
}

// As refined() in curve_skeleton.cpp.
HWY_INLINE V refined(const SpanV& span, const Vec3V& p, V t)
{
    const D d;
    const V zero = hn::Zero(d);
    for (int i = 0; i < curve_newton_steps; ++i) {
        const Vec3V at = span.at(t), slope = span.slope(t);
        const Vec3V off{at.x - p.x, at.y - p.y, at.z - p.z};
        const V speed_sq = dot(slope, slope);
        const V full = speed_sq + dot(off, span.bend(t));
        const V second = hn::IfThenElse(hn::Gt(full, hn::Set(d, 0.1) * speed_sq), full, speed_sq);
        const auto moves = hn::Gt(second, zero);
        const V step = dot(off, slope) / hn::IfThenElse(moves, second, hn::Set(d, 1.0));
        t = clamped(t - hn::IfThenElseZero(moves, step));
    }
    return t;
}

void AddCurve(const Vec3* bezier, std::size_t count, const FieldProfile& p, const FieldBlock& block,
              BlockValues& sum)
{
    const D d;
    const std::span<const Vec3> points(bezier, count);
    add_offsets(p, block, sum, [&](std::size_t i, V& dx, V& dy, V& dz) HWY_ATTR {
        const Vec3V at{hn::Load(d, block.x + i), hn::Load(d, block.y + i),
                       hn::Load(d, block.z + i)};
        V nearest = hn::Set(d, 1e150);
        dx = hn::Set(d, 1e150);
        dy = dz = hn::Zero(d);
        for (std::size_t s = 0; s < curve_span_count(points); ++s) {
            const CurveSpan span = curve_span(points, s);
            V chord_sq;
            V t = nearest_chord(span, at, chord_sq);
            const auto may = hn::Lt(hn::Sqrt(chord_sq) - hn::Set(d, span.off), nearest);
            if (hn::AllFalse(d, may)) continue;
            const SpanV lanes(span);
            t = refined(lanes, at, t);
            const Vec3V foot = lanes.at(t);
            const Vec3V o{at.x - foot.x, at.y - foot.y, at.z - foot.z};
            const V r = hn::Sqrt(dot(o, o));
            const auto closer = hn::And(may, hn::Lt(r, nearest));
            nearest = hn::IfThenElse(closer, r, nearest);
            dx = hn::IfThenElse(closer, o.x, dx);
            dy = hn::IfThenElse(closer, o.y, dy);
            dz = hn::IfThenElse(closer, o.z, dz);
        }
    });
}

struct RoundFoot {
    V r, n_rho, n_y;
};

// As foot_on_torus().
HWY_INLINE RoundFoot on_torus(const RoundShape& shape, V rho, V y)
{
    const D d;
    const V zero = hn::Zero(d);
    const V out = rho - hn::Set(d, shape.ring);
    const V q = hn::Sqrt(out * out + y * y);
    const V safe = hn::IfThenElse(hn::Gt(q, zero), q, hn::Set(d, 1.0));
    return {q - hn::Set(d, shape.tube), out / safe, y / safe};
}

// As foot_on_cone().
HWY_INLINE RoundFoot on_cone(const RoundShape& shape, V rho, V y)
{
    const D d;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0), minus = hn::Set(d, -1.0);
    const V base = hn::Set(d, shape.base), top = hn::Set(d, shape.top),
            height = hn::Set(d, shape.height);
    const double in_one = shape.base - shape.top, tall_one = 2 * shape.height;
    const double length_sq = in_one * in_one + tall_one * tall_one;
    const double length = std::sqrt(length_sq);
    const V in = hn::Set(d, in_one), tall = hn::Set(d, tall_one);
    const auto low = hn::Lt(y, zero);
    const V up = hn::IfThenElse(low, minus, one);
    const V cap_rho = hn::Max(rho - hn::IfThenElse(low, base, top), zero);
    const V cap_y = up * y - height;
    const V s = clamped(((rho - top) * in + (height - y) * tall) / hn::Set(d, length_sq));
    const V side_rho = rho - top - in * s, side_y = y - height + tall * s;
    const auto inside = hn::And(hn::Lt(side_rho, zero), hn::Lt(cap_y, zero));
    const V sign = hn::IfThenElse(inside, minus, one);
    const V cap_sq = cap_rho * cap_rho + cap_y * cap_y;
    const V side_sq = side_rho * side_rho + side_y * side_y;
    const auto cap = hn::Lt(cap_sq, side_sq);
    const V q = hn::Sqrt(hn::IfThenElse(cap, cap_sq, side_sq));
    const auto off = hn::Gt(q, zero);
    const V w = sign / hn::IfThenElse(off, q, one);
    const V n_rho = hn::IfThenElse(cap, cap_rho, side_rho) * w;
    const V n_y = hn::IfThenElse(cap, up * cap_y, side_y) * w;
    const V flat_rho = hn::IfThenElse(cap, zero, hn::Set(d, tall_one / length));
    const V flat_y = hn::IfThenElse(cap, up, hn::Set(d, in_one / length));
    return {sign * q, hn::IfThenElse(off, n_rho, flat_rho), hn::IfThenElse(off, n_y, flat_y)};
}

// on(rho, y): distance and gradient in the half plane.
template <class On>
HWY_INLINE void add_turned(const Transform& place, const FieldProfile& p, const FieldBlock& block,
                           BlockValues& sum, const On& on)
{
    const D d;
    const Spread profile_v(p);
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0);
    const Vec3V x_axis = spread(place.linear().col(0)), y_axis = spread(place.linear().col(1)),
                z_axis = spread(place.linear().col(2)), origin = spread(place.translation());
    for_lanes(block.count, [&](std::size_t i) HWY_ATTR {
        const Vec3V e{hn::Load(d, block.x + i) - origin.x, hn::Load(d, block.y + i) - origin.y,
                      hn::Load(d, block.z + i) - origin.z};
        const V x = dot(e, x_axis), y = dot(e, y_axis), z = dot(e, z_axis);
        const V rho = hn::Sqrt(x * x + z * z);
        const RoundFoot foot = on(rho, y);
        if (hn::AllFalse(d, hn::Lt(foot.r, profile_v.R))) return;
        V f, slope;
        profile(profile_v, foot.r, f, slope);
        const auto off_axis = hn::Gt(rho, zero);
        const V safe = hn::IfThenElse(off_axis, rho, one);
        const V nx = foot.n_rho * hn::IfThenElse(off_axis, x / safe, one);
        const V nz = foot.n_rho * z / safe;
        const V ny = foot.n_y;
        add(sum.f + i, f);
        add(sum.gx + i, slope * (nx * x_axis.x + ny * y_axis.x + nz * z_axis.x));
        add(sum.gy + i, slope * (nx * x_axis.y + ny * y_axis.y + nz * z_axis.y));
        add(sum.gz + i, slope * (nx * x_axis.z + ny * y_axis.z + nz * z_axis.z));
    });
}

void AddTorus(const RoundShape& shape, const Transform& place, const FieldProfile& p,
              const FieldBlock& block, BlockValues& sum)
{
    add_turned(place, p, block, sum, [&](V rho, V y) HWY_ATTR { return on_torus(shape, rho, y); });
}

void AddCone(const RoundShape& shape, const Transform& place, const FieldProfile& p,
             const FieldBlock& block, BlockValues& sum)
{
    add_turned(place, p, block, sum, [&](V rho, V y) HWY_ATTR { return on_cone(shape, rho, y); });
}

void AddFeet(const BlockValues& feet, const FieldProfile& p, std::size_t count, BlockValues& sum)
{
    const D d;
    const Spread spread(p);
    for_lanes(count, [&](std::size_t i) HWY_ATTR {
        V f, slope;
        profile(spread, hn::Load(d, feet.f + i), f, slope);
        add(sum.f + i, f);
        add(sum.gx + i, slope * hn::Load(d, feet.gx + i));
        add(sum.gy + i, slope * hn::Load(d, feet.gy + i));
        add(sum.gz + i, slope * hn::Load(d, feet.gz + i));
    });
}

}  // namespace geometry::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace geometry {

HWY_EXPORT(AddPoint);
HWY_EXPORT(AddPolyline);
HWY_EXPORT(AddFeet);
HWY_EXPORT(AddCurve);
HWY_EXPORT(AddTorus);
HWY_EXPORT(AddCone);

void add_polyline(std::span<const Vec3> points, const FieldProfile& profile,
                  const FieldBlock& block, BlockValues& sum)
{
    if (points.size() == 1) return HWY_DYNAMIC_DISPATCH(AddPoint)(points[0], profile, block, sum);
    HWY_DYNAMIC_DISPATCH(AddPolyline)(points.data(), points.size(), profile, block, sum);
}

void add_curve(std::span<const Vec3> bezier, const FieldProfile& profile, const FieldBlock& block,
               BlockValues& sum)
{
    HWY_DYNAMIC_DISPATCH(AddCurve)(bezier.data(), bezier.size(), profile, block, sum);
}

void add_round(SkeletonKind kind, const Vec3& half_size, const Transform& place,
               const FieldProfile& profile, const FieldBlock& block, BlockValues& sum)
{
    const RoundShape shape = round_shape(kind, half_size);
    if (kind == SkeletonKind::torus) {
        return HWY_DYNAMIC_DISPATCH(AddTorus)(shape, place, profile, block, sum);
    }
    HWY_DYNAMIC_DISPATCH(AddCone)(shape, place, profile, block, sum);
}

void add_feet(const BlockValues& feet, const FieldProfile& profile, std::size_t count,
              BlockValues& sum)
{
    HWY_DYNAMIC_DISPATCH(AddFeet)(feet, profile, count, sum);
}

}  // namespace geometry
#endif  // HWY_ONCE
