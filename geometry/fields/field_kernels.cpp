#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geometry/fields/field_kernels.cpp"
#include <hwy/foreach_target.h>  // compiles the rest of this file once for each instruction set

#include "geometry/fields/field_kernels.hpp"

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

void add_polyline(std::span<const Vec3> points, const FieldProfile& profile,
                  const FieldBlock& block, BlockValues& sum)
{
    if (points.size() == 1) return HWY_DYNAMIC_DISPATCH(AddPoint)(points[0], profile, block, sum);
    HWY_DYNAMIC_DISPATCH(AddPolyline)(points.data(), points.size(), profile, block, sum);
}

void add_feet(const BlockValues& feet, const FieldProfile& profile, std::size_t count,
              BlockValues& sum)
{
    HWY_DYNAMIC_DISPATCH(AddFeet)(feet, profile, count, sum);
}

}  // namespace geometry
#endif  // HWY_ONCE
