// The arithmetic that all kernels of bricks share (brick_kernels.hpp has its equations): corners of
// 16 cubes in and out of a block, monomials C_m and back, rotation of a field, K of a cube.
// Included once for each Highway target.

#if defined(PHYSICS_BRICK_KERNELS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef PHYSICS_BRICK_KERNELS_INL_HPP
#undef PHYSICS_BRICK_KERNELS_INL_HPP
#else
#define PHYSICS_BRICK_KERNELS_INL_HPP
#endif

#include "geometry/base/no_index.hpp"
#include "physics/bricks/brick_kernels.hpp"
#include "physics/bricks/brick_layout.hpp"
#include "physics/state/cube_mass.hpp"

#include <hwy/highway.h>

#include <cstring>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Room for the corners of one block: four numbers a corner, [8][16][4].
template <class T> struct CornerBuffer {
    HWY_ALIGN T at[8 * block_lanes * 4];
};

template <class T>
HWY_INLINE void gather_corners(const std::uint32_t* slots, const T* p, CornerBuffer<T>& out)
{
    for (std::size_t i = 0; i < 8 * block_lanes; ++i) {
        std::memcpy(out.at + 4 * i, p + 4 * std::size_t{slots[i]}, 4 * sizeof(T));
    }
}

// In order, so that cubes of one block may share corners.
template <class T>
HWY_INLINE void scatter_corners(const std::uint32_t* slots, const CornerBuffer<T>& in, T* q)
{
    for (std::size_t i = 0; i < 8 * block_lanes; ++i) {
        T* to = q + 4 * std::size_t{slots[i]};
        for (std::size_t k = 0; k < 4; ++k) to[k] += in.at[4 * i + k];
    }
}

// The coefficients C_m of one component, for m = x y z xy yz zx xyz.
template <class V> struct Monomials {
    V x, y, z, xy, yz, zx, xyz;
};

template <class V> HWY_INLINE Monomials<V> butterfly(const V (&u)[8])
{
    const V p0 = hn::Add(u[0], u[1]), m0 = hn::Sub(u[1], u[0]);
    const V p1 = hn::Add(u[2], u[3]), m1 = hn::Sub(u[3], u[2]);
    const V p2 = hn::Add(u[4], u[5]), m2 = hn::Sub(u[5], u[4]);
    const V p3 = hn::Add(u[6], u[7]), m3 = hn::Sub(u[7], u[6]);
    const V pp0 = hn::Add(p0, p1), pm0 = hn::Sub(p1, p0);
    const V mp0 = hn::Add(m0, m1), mm0 = hn::Sub(m1, m0);
    const V pp1 = hn::Add(p2, p3), pm1 = hn::Sub(p3, p2);
    const V mp1 = hn::Add(m2, m3), mm1 = hn::Sub(m3, m2);
    return {hn::Add(mp0, mp1), hn::Add(pm0, pm1), hn::Sub(pp1, pp0), hn::Add(mm0, mm1),
            hn::Sub(pm1, pm0), hn::Sub(mp1, mp0), hn::Sub(mm1, mm0)};
}

// Corner values sum_m s_a^m F_m.
template <class V> HWY_INLINE void butterfly_back(const Monomials<V>& f, V (&u)[8])
{
    const V mp1 = hn::Add(f.x, f.zx), mp0 = hn::Sub(f.x, f.zx);
    const V pm1 = hn::Add(f.y, f.yz), pm0 = hn::Sub(f.y, f.yz);
    const V mm1 = hn::Add(f.xy, f.xyz), mm0 = hn::Sub(f.xy, f.xyz);
    const V pp1 = f.z, pp0 = hn::Neg(f.z);
    const V m3 = hn::Add(mp1, mm1), m2 = hn::Sub(mp1, mm1);
    const V m1 = hn::Add(mp0, mm0), m0 = hn::Sub(mp0, mm0);
    const V p3 = hn::Add(pp1, pm1), p2 = hn::Sub(pp1, pm1);
    const V p1 = hn::Add(pp0, pm0), p0 = hn::Sub(pp0, pm0);
    u[0] = hn::Sub(p0, m0), u[1] = hn::Add(p0, m0);
    u[2] = hn::Sub(p1, m1), u[3] = hn::Add(p1, m1);
    u[4] = hn::Sub(p2, m2), u[5] = hn::Add(p2, m2);
    u[6] = hn::Sub(p3, m3), u[7] = hn::Add(p3, m3);
}

// Three components of all monomials.
template <class V> struct BrickField {
    Monomials<V> of[3];
};

template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> load_field(D d, const CornerBuffer<T>& buffer, std::size_t lane)
{
    V u[3][8], none;
    for (std::size_t a = 0; a < 8; ++a) {
        hn::LoadInterleaved4(d, buffer.at + 4 * (a * block_lanes + lane), u[0][a], u[1][a], u[2][a],
                             none);
    }
    return {{butterfly(u[0]), butterfly(u[1]), butterfly(u[2])}};
}

template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE void store_field(D d, const BrickField<V>& f, CornerBuffer<T>& buffer, std::size_t lane)
{
    V u[3][8];
    for (int i = 0; i < 3; ++i) butterfly_back(f.of[i], u[i]);
    for (std::size_t a = 0; a < 8; ++a) {
        hn::StoreInterleaved4(u[0][a], u[1][a], u[2][a], hn::Zero(d), d,
                              buffer.at + 4 * (a * block_lanes + lane));
    }
}

// Less the p of plastic_rows, from the lane that `rows` begins with.
template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> without_plastic(D d, const T* rows, BrickField<V> c)
{
    const auto next = [&]() HWY_ATTR {
        const V v = hn::LoadU(d, rows);
        rows += block_lanes;
        return v;
    };
    const auto less = [](V& from, V p) HWY_ATTR { from = hn::Sub(from, p); };
    less(c.of[0].x, next());
    const V xy = next(), xz = next();
    less(c.of[0].y, xy), less(c.of[1].x, xy);
    less(c.of[0].z, xz), less(c.of[2].x, xz);
    less(c.of[1].y, next());
    const V yz = next();
    less(c.of[1].z, yz), less(c.of[2].y, yz);
    less(c.of[2].z, next());
    for (Monomials<V>& of : c.of) less(of.xy, next());
    for (Monomials<V>& of : c.of) less(of.yz, next());
    for (Monomials<V>& of : c.of) less(of.zx, next());
    for (Monomials<V>& of : c.of) less(of.xyz, next());
    return c;
}

template <class V> HWY_INLINE V dot3(V a0, V b0, V a1, V b1, V a2, V b2)
{
    return hn::Add(hn::Add(hn::Mul(a0, b0), hn::Mul(a1, b1)), hn::Mul(a2, b2));
}

template <class V, class Each>
HWY_INLINE void for_each_monomial(const BrickField<V>& in, BrickField<V>& out, const Each& each)
{
    const auto one = [&](V Monomials<V>::*m) HWY_ATTR {
        each(in.of[0].*m, in.of[1].*m, in.of[2].*m, out.of[0].*m, out.of[1].*m, out.of[2].*m);
    };
    one(&Monomials<V>::x), one(&Monomials<V>::y), one(&Monomials<V>::z);
    one(&Monomials<V>::xy), one(&Monomials<V>::yz), one(&Monomials<V>::zx);
    one(&Monomials<V>::xyz);
}

template <class V> HWY_INLINE BrickField<V> rotated(const V (&r)[9], const BrickField<V>& in)
{
    BrickField<V> out;
    for_each_monomial(in, out, [&](V a, V b, V c, V& x, V& y, V& z) HWY_ATTR {
        x = dot3(r[0], a, r[1], b, r[2], c);
        y = dot3(r[3], a, r[4], b, r[5], c);
        z = dot3(r[6], a, r[7], b, r[8], c);
    });
    return out;
}

template <class V> HWY_INLINE BrickField<V> rotated_back(const V (&r)[9], const BrickField<V>& in)
{
    BrickField<V> out;
    for_each_monomial(in, out, [&](V a, V b, V c, V& x, V& y, V& z) HWY_ATTR {
        x = dot3(r[0], a, r[3], b, r[6], c);
        y = dot3(r[1], a, r[4], b, r[7], c);
        z = dot3(r[2], a, r[5], b, r[8], c);
    });
    return out;
}

// What the stress at the middle of the axis-aligned cube gives: F_x, F_y, F_z.
template <class V>
HWY_INLINE void set_middle(const BrickField<V>& c, V mu, V lambda, BrickField<V>& f)
{
    const Monomials<V>&u = c.of[0], &v = c.of[1], &w = c.of[2];
    const V mu2 = hn::Add(mu, mu);
    const V pressure = hn::Mul(lambda, hn::Add(hn::Add(u.x, v.y), w.z));
    f.of[0].x = hn::Add(hn::Mul(mu2, u.x), pressure);
    f.of[1].y = hn::Add(hn::Mul(mu2, v.y), pressure);
    f.of[2].z = hn::Add(hn::Mul(mu2, w.z), pressure);
    f.of[0].y = f.of[1].x = hn::Mul(mu, hn::Add(u.y, v.x));
    f.of[1].z = f.of[2].y = hn::Mul(mu, hn::Add(v.z, w.y));
    f.of[2].x = f.of[0].z = hn::Mul(mu, hn::Add(w.x, u.z));
}

// K of the axis-aligned cube.
template <class D, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> stiffness_times(D d, const BrickField<V>& c, V mu, V lambda, V lambda_bend,
                                         V plain, V lambda_hourglass)
{
    using T = hn::TFromD<D>;
    const Monomials<V>&u = c.of[0], &v = c.of[1], &w = c.of[2];
    BrickField<V> f;
    set_middle(c, mu, lambda, f);
    const V mu2 = hn::Add(mu, mu);

    const V third = hn::Set(d, T(1) / T(3));
    const V mu_3 = hn::Mul(mu, third), lambda_3 = hn::Mul(lambda_bend, third);
    const V mu2_3 = hn::Add(mu_3, mu_3), mu_plain = hn::Mul(mu_3, plain);
    // n = x holds yy and zz of C_xy[y] and C_zx[z], and so on round.
    const V bend_x = hn::Mul(lambda_3, hn::Add(v.xy, w.zx));
    const V bend_y = hn::Mul(lambda_3, hn::Add(u.xy, w.yz));
    const V bend_z = hn::Mul(lambda_3, hn::Add(u.zx, v.yz));
    const V own = hn::Add(mu2_3, mu_plain);
    f.of[1].xy = hn::Add(hn::Mul(own, v.xy), bend_x);
    f.of[2].zx = hn::Add(hn::Mul(own, w.zx), bend_x);
    f.of[0].xy = hn::Add(hn::Mul(own, u.xy), bend_y);
    f.of[2].yz = hn::Add(hn::Mul(own, w.yz), bend_y);
    f.of[0].zx = hn::Add(hn::Mul(own, u.zx), bend_z);
    f.of[1].yz = hn::Add(hn::Mul(own, v.yz), bend_z);
    // Twist: n = x shears C_xy[z] + C_zx[y], n = y C_yz[x] + C_xy[z], n = z C_yz[x] + C_zx[y].
    const V twist = hn::Add(hn::Add(w.xy, v.zx), u.yz);
    f.of[2].xy = hn::Mul(mu_3, hn::Add(w.xy, twist));
    f.of[1].zx = hn::Mul(mu_3, hn::Add(v.zx, twist));
    f.of[0].yz = hn::Mul(mu_3, hn::Add(u.yz, twist));

    const V ninth = hn::Set(d, T(1) / T(9));
    const V hourglass = hn::Mul(ninth, hn::Add(hn::Add(mu2, mu2), lambda_hourglass));
    f.of[0].xyz = hn::Mul(hourglass, u.xyz);
    f.of[1].xyz = hn::Mul(hourglass, v.xyz);
    f.of[2].xyz = hn::Mul(hourglass, w.xyz);
    return f;
}

// K of the axis-aligned cube with one point.
template <class D, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> one_point_times(D d, const BrickField<V>& c, V mu, V lambda, V young)
{
    using T = hn::TFromD<D>;
    BrickField<V> f;
    set_middle(c, mu, lambda, f);
    const V third = hn::Set(d, T(1) / T(3));
    const V bend = hn::Mul(young, third), twist = hn::Mul(mu, third);
    const V last = hn::Mul(mu, hn::Set(d, T(4) / T(9)));
    const V xy[3] = {bend, bend, twist}, yz[3] = {twist, bend, bend}, zx[3] = {bend, twist, bend};
    for (int i = 0; i < 3; ++i) {
        f.of[i].xy = hn::Mul(xy[i], c.of[i].xy);
        f.of[i].yz = hn::Mul(yz[i], c.of[i].yz);
        f.of[i].zx = hn::Mul(zx[i], c.of[i].zx);
        f.of[i].xyz = hn::Mul(last, c.of[i].xyz);
    }
    return f;
}

// out = A in, A symmetric: its lower triangle row by row, each entry a row of lanes.
template <class D, class T, std::size_t n, class V = hn::Vec<D>>
HWY_INLINE void triangle_times(D d, const T* entries, const V (&in)[n], V (&out)[n])
{
    for (std::size_t i = 0; i < n; ++i) {
        V sum = hn::Zero(d);
        for (std::size_t j = 0; j < i; ++j, entries += block_lanes) {
            const V entry = hn::LoadU(d, entries);
            sum = hn::Add(sum, hn::Mul(entry, in[j]));
            out[j] = hn::Add(out[j], hn::Mul(entry, in[i]));
        }
        out[i] = hn::Add(sum, hn::Mul(hn::LoadU(d, entries), in[i]));
        entries += block_lanes;
    }
}

// H of the `own`-th block that has one.
template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> own_times(D d, const BrickCoefficients<T>& bricks, std::size_t own,
                                   std::size_t lane, const BrickField<V>& c)
{
    V in[field_numbers], out[field_numbers];
    BrickField<V> f;
    std::size_t at = 0;
    for_each_monomial(c, f, [&](V x, V y, V z, V&, V&, V&) HWY_ATTR {
        in[at] = x, in[at + 1] = y, in[at + 2] = z;
        at += 3;
    });
    triangle_times(d, bricks.own + own * own_rows * block_lanes + lane, in, out);
    const V weight = bricks.own_weight ? hn::LoadU(d, bricks.own_weight + own * block_lanes + lane)
                                       : hn::Set(d, T(1));
    at = 0;
    for_each_monomial(c, f, [&](V, V, V, V& x, V& y, V& z) HWY_ATTR {
        x = hn::Mul(weight, out[at]);
        y = hn::Mul(weight, out[at + 1]);
        z = hn::Mul(weight, out[at + 2]);
        at += 3;
    });
    return f;
}

template <class D, class V = hn::Vec<D>, class T>
HWY_INLINE BrickField<V> stiffness_times(D d, const BrickCoefficients<T>& bricks, std::size_t block,
                                         std::size_t lane, const BrickField<V>& c)
{
    if (bricks.own_at && bricks.own_at[block] != geometry::no_index) {
        return own_times(d, bricks, bricks.own_at[block], lane, c);
    }
    const T* k = bricks.stiffness + block * 3 * block_lanes + lane;
    const V mu = hn::LoadU(d, k), lambda = hn::LoadU(d, k + block_lanes);
    const V third = hn::LoadU(d, k + 2 * block_lanes);
    if (bricks.element == BrickElement::one_point) return one_point_times(d, c, mu, lambda, third);
    const V plain = hn::Set(d, T(bricks.element == BrickElement::trilinear ? 1 : 0));
    return stiffness_times(d, c, mu, lambda, third, plain,
                           bricks.element == BrickElement::relaxed ? third : lambda);
}

// N of the `own`-th block that has one.
template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> own_excess_times(D d, const BrickCoefficients<T>& bricks, std::size_t own,
                                          std::size_t lane, V mass, const BrickField<V>& c)
{
    BrickField<V> f;
    for (int component = 0; component < 3; ++component) {
        const Monomials<V>& u = c.of[component];
        const V in[7] = {u.x, u.y, u.z, u.xy, u.yz, u.zx, u.xyz};
        V out[7];
        triangle_times(d, bricks.own_mass + own * own_mass_rows * block_lanes + lane, in, out);
        f.of[component] = {hn::Mul(mass, out[0]), hn::Mul(mass, out[1]), hn::Mul(mass, out[2]),
                           hn::Mul(mass, out[3]), hn::Mul(mass, out[4]), hn::Mul(mass, out[5]),
                           hn::Mul(mass, out[6])};
    }
    return f;
}

// N of a cube.
template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> excess_times(D d, const BrickCoefficients<T>& bricks, std::size_t block,
                                      std::size_t lane, const BrickField<V>& c)
{
    const V mass = hn::LoadU(d, bricks.excess + block * block_lanes + lane);
    if (bricks.own_at && bricks.own_at[block] != geometry::no_index) {
        return own_excess_times(d, bricks, bricks.own_at[block], lane, mass, c);
    }
    const auto lacks = [&](std::size_t degree) HWY_ATTR {
        return hn::Mul(mass, hn::Set(d, T(1 - mass_shares[degree])));
    };
    const V one = lacks(1), two = lacks(2), three = lacks(3);
    BrickField<V> f;
    for (int i = 0; i < 3; ++i) {
        const Monomials<V>& u = c.of[i];
        f.of[i] = {hn::Mul(one, u.x),  hn::Mul(one, u.y),  hn::Mul(one, u.z),    hn::Mul(two, u.xy),
                   hn::Mul(two, u.yz), hn::Mul(two, u.zx), hn::Mul(three, u.xyz)};
    }
    return f;
}

// f -= N c, where bricks have it.
template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE void subtract_excess(D d, const BrickCoefficients<T>& bricks, std::size_t block,
                                std::size_t lane, const BrickField<V>& c, BrickField<V>& f)
{
    if (!bricks.excess) return;
    const auto excess = excess_times(d, bricks, block, lane, c);
    for_each_monomial(excess, f, [&](V a, V b, V e, V& x, V& y, V& z) HWY_ATTR {
        x = hn::Sub(x, a), y = hn::Sub(y, b), z = hn::Sub(z, e);
    });
}

// a x b added to s.
template <class V>
HWY_INLINE void add_cross(V a0, V a1, V a2, V b0, V b1, V b2, V& s0, V& s1, V& s2)
{
    s0 = hn::Add(s0, hn::Sub(hn::Mul(a1, b2), hn::Mul(a2, b1)));
    s1 = hn::Add(s1, hn::Sub(hn::Mul(a2, b0), hn::Mul(a0, b2)));
    s2 = hn::Add(s2, hn::Sub(hn::Mul(a0, b1), hn::Mul(a1, b0)));
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#endif
