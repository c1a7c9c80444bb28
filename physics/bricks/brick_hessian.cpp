#include "physics/bricks/brick_hessian.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/bricks/brick_hessian.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/bricks/brick_kernels-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A lane's part of strained_rows.
template <class V> struct Strain {
    BrickField<V> d;
    V inverse[6], q[3];
};

template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE Strain<V> load_strain(D d, const T* rows)
{
    Strain<V> s;
    const auto one = [&](V& v) HWY_ATTR {
        v = hn::LoadU(d, rows);
        rows += block_lanes;
    };
    for (Monomials<V>& m : s.d.of) {
        one(m.x), one(m.y), one(m.z), one(m.xy), one(m.yz), one(m.zx), one(m.xyz);
    }
    for (V& v : s.inverse) one(v);
    for (V& v : s.q) one(v);
    return s;
}

template <class V> HWY_INLINE void scale_field(V factor, BrickField<V>& f)
{
    for_each_monomial(f, f, [&](V a, V b, V c, V& x, V& y, V& z) HWY_ATTR {
        x = hn::Mul(factor, a), y = hn::Mul(factor, b), z = hn::Mul(factor, c);
    });
}

// out += w x in, monomial by monomial; or -= where `less`.
template <class V>
HWY_INLINE void add_turned(const V (&w)[3], bool less, const BrickField<V>& in, BrickField<V>& out)
{
    for_each_monomial(in, out, [&](V a, V b, V c, V& x, V& y, V& z) HWY_ATTR {
        if (less) {
            add_cross(a, b, c, w[0], w[1], w[2], x, y, z);
        } else {
            add_cross(w[0], w[1], w[2], a, b, c, x, y, z);
        }
    });
}

// t += sum_m a_m x b_m
template <class V>
HWY_INLINE void add_moment(const BrickField<V>& a, const BrickField<V>& b, V (&t)[3])
{
    const auto one = [&](V Monomials<V>::*m) HWY_ATTR {
        add_cross(a.of[0].*m, a.of[1].*m, a.of[2].*m, b.of[0].*m, b.of[1].*m, b.of[2].*m, t[0],
                  t[1], t[2]);
    };
    one(&Monomials<V>::x), one(&Monomials<V>::y), one(&Monomials<V>::z);
    one(&Monomials<V>::xy), one(&Monomials<V>::yz), one(&Monomials<V>::zx);
    one(&Monomials<V>::xyz);
}

// out = m t, m symmetric as xx xy xz yy yz zz
template <class V> HWY_INLINE void symmetric_times(const V (&m)[6], const V (&t)[3], V (&out)[3])
{
    out[0] = dot3(m[0], t[0], m[1], t[1], m[2], t[2]);
    out[1] = dot3(m[1], t[0], m[3], t[1], m[4], t[2]);
    out[2] = dot3(m[2], t[0], m[4], t[1], m[5], t[2]);
}

// f_xj += e_j x q
template <class V> HWY_INLINE void add_columns(const V (&q)[3], BrickField<V>& f)
{
    f.of[1].x = hn::Sub(f.of[1].x, q[2]), f.of[2].x = hn::Add(f.of[2].x, q[1]);
    f.of[0].y = hn::Add(f.of[0].y, q[2]), f.of[2].y = hn::Sub(f.of[2].y, q[0]);
    f.of[0].z = hn::Sub(f.of[0].z, q[1]), f.of[1].z = hn::Add(f.of[1].z, q[0]);
}

// t -= (tr(S) I - S) q for S the symmetric part of the linear monomials of c
template <class D, class V = hn::Vec<D>>
HWY_INLINE void subtract_spread(D d, const BrickField<V>& c, const V (&q)[3], V (&t)[3])
{
    const V half = hn::Set(d, hn::TFromD<D>(0.5));
    const V xy = hn::Mul(half, hn::Add(c.of[0].y, c.of[1].x));
    const V xz = hn::Mul(half, hn::Add(c.of[0].z, c.of[2].x));
    const V yz = hn::Mul(half, hn::Add(c.of[1].z, c.of[2].y));
    const V xx = hn::Add(c.of[1].y, c.of[2].z), yy = hn::Add(c.of[0].x, c.of[2].z);
    const V zz = hn::Add(c.of[0].x, c.of[1].y);
    const V m[6] = {xx, hn::Neg(xy), hn::Neg(xz), yy, hn::Neg(yz), zz};
    V spread[3];
    symmetric_times(m, q, spread);
    for (int i = 0; i < 3; ++i) t[i] = hn::Sub(t[i], spread[i]);
}

// m K dy, and s times the rest of the second derivative.
template <class D, class T, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> hessian_times(D d, const BrickCoefficients<T>& bricks,
                                       const BrickCurvature<T>& curvature, std::size_t block,
                                       std::size_t lane, const BrickField<V>& dy)
{
    const auto at = load_strain(d, curvature.strained + block * strained_rows * block_lanes + lane);
    const V share = hn::LoadU(d, curvature.share + block * block_lanes + lane);
    const V s = hn::Set(d, curvature.stiffness), edge = hn::Set(d, curvature.edge);
    const V turn[3] = {hn::Sub(dy.of[2].y, dy.of[1].z), hn::Sub(dy.of[0].z, dy.of[2].x),
                       hn::Sub(dy.of[1].x, dy.of[0].y)};
    V w[3];
    symmetric_times(at.inverse, turn, w);
    auto y = at.d;
    y.of[0].x = hn::Add(y.of[0].x, edge);
    y.of[1].y = hn::Add(y.of[1].y, edge);
    y.of[2].z = hn::Add(y.of[2].z, edge);
    auto dd = dy;
    add_turned(w, true, y, dd);
    auto elastic = at.d;
    if (curvature.plastic) {
        const T* rows = curvature.plastic + block * plastic_rows * block_lanes + lane;
        elastic = without_plastic(d, rows, at.d);
    }
    auto f = stiffness_times(d, bricks, block, lane, elastic);
    auto df = stiffness_times(d, bricks, block, lane, dd);
    scale_field(share, f), scale_field(share, df);
    V t[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    add_moment(dd, f, t), add_moment(at.d, df, t);
    V q[3], dq[3];
    for (int i = 0; i < 3; ++i) q[i] = hn::Mul(s, at.q[i]);
    subtract_spread(d, dd, q, t);
    symmetric_times(at.inverse, t, dq);
    add_columns(q, f);  // F + E
    auto out = stiffness_times(d, bricks, block, lane, dy);
    scale_field(hn::Sub(hn::Set(d, T(1)), share), out);
    for_each_monomial(df, out, [&](V a, V b, V c, V& x, V& yy, V& z) HWY_ATTR {
        x = hn::Add(x, a), yy = hn::Add(yy, b), z = hn::Add(z, c);
    });
    add_turned(w, false, f, out);
    add_columns(dq, out);
    return out;
}

template <class T>
HWY_INLINE void add_hessian(const BrickCoefficients<T>& bricks, const BrickCurvature<T>& curvature,
                            std::size_t begin, std::size_t end, const T* p, T* q)
{
    const hn::CappedTag<T, block_lanes> d;
    CornerBuffer<T> corners, forces;
    for (std::size_t block = begin; block < end; ++block) {
        gather_corners(bricks.gather + block * 8 * block_lanes, p, corners);
        for (std::size_t lane = 0; lane < block_lanes; lane += hn::Lanes(d)) {
            hn::Vec<decltype(d)> r[9];
            for (std::size_t k = 0; k < 9; ++k) {
                r[k] = hn::LoadU(d, bricks.rotation + (block * 9 + k) * block_lanes + lane);
            }
            const auto dy = rotated_back(r, load_field(d, corners, lane));
            auto f = hessian_times(d, bricks, curvature, block, lane, dy);
            subtract_excess(d, bricks, block, lane, dy, f);
            store_field(d, rotated(r, f), forces, lane);
        }
        scatter_corners(bricks.scatter + block * 8 * block_lanes, forces, q);
    }
}

void add_hessian_low(const BrickCoefficients<float>& bricks, const BrickCurvature<float>& curvature,
                     std::size_t begin, std::size_t end, const float* p, float* q)
{
    add_hessian(bricks, curvature, begin, end, p, q);
}

void add_hessian_high(const BrickCoefficients<double>& bricks,
                      const BrickCurvature<double>& curvature, std::size_t begin, std::size_t end,
                      const double* p, double* q)
{
    add_hessian(bricks, curvature, begin, end, p, q);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(add_hessian_low);
HWY_EXPORT(add_hessian_high);

void add_hessian_times(const BrickCoefficients<float>& bricks,
                       const BrickCurvature<float>& curvature, std::size_t begin, std::size_t end,
                       const float* p, float* q)
{
    HWY_DYNAMIC_DISPATCH(add_hessian_low)(bricks, curvature, begin, end, p, q);
}

void add_hessian_times(const BrickCoefficients<double>& bricks,
                       const BrickCurvature<double>& curvature, std::size_t begin, std::size_t end,
                       const double* p, double* q)
{
    HWY_DYNAMIC_DISPATCH(add_hessian_high)(bricks, curvature, begin, end, p, q);
}

}  // namespace physics
#endif
