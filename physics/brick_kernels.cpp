#include "physics/brick_kernels.hpp"

#include "physics/brick_layout.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/brick_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/rotation-inl.hpp"

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

// K of the axis-aligned cube.
template <class D, class V = hn::Vec<D>>
HWY_INLINE BrickField<V> stiffness_times(D d, const BrickField<V>& c, V mu, V lambda, V lambda_bend,
                                         V plain)
{
    using T = hn::TFromD<D>;
    const Monomials<V>&u = c.of[0], &v = c.of[1], &w = c.of[2];
    BrickField<V> f;
    const V mu2 = hn::Add(mu, mu);

    const V pressure = hn::Mul(lambda, hn::Add(hn::Add(u.x, v.y), w.z));
    f.of[0].x = hn::Add(hn::Mul(mu2, u.x), pressure);
    f.of[1].y = hn::Add(hn::Mul(mu2, v.y), pressure);
    f.of[2].z = hn::Add(hn::Mul(mu2, w.z), pressure);
    f.of[0].y = f.of[1].x = hn::Mul(mu, hn::Add(u.y, v.x));
    f.of[1].z = f.of[2].y = hn::Mul(mu, hn::Add(v.z, w.y));
    f.of[2].x = f.of[0].z = hn::Mul(mu, hn::Add(w.x, u.z));

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
    const V hourglass = hn::Mul(ninth, hn::Add(hn::Add(mu2, mu2), lambda));
    f.of[0].xyz = hn::Mul(hourglass, u.xyz);
    f.of[1].xyz = hn::Mul(hourglass, v.xyz);
    f.of[2].xyz = hn::Mul(hourglass, w.xyz);
    return f;
}

template <class D, class V = hn::Vec<D>, class T>
HWY_INLINE BrickField<V> stiffness_times(D d, const BrickCoefficients<T>& bricks, std::size_t block,
                                         std::size_t lane, const BrickField<V>& c)
{
    const T* k = bricks.stiffness + block * 3 * block_lanes + lane;
    return stiffness_times(d, c, hn::LoadU(d, k), hn::LoadU(d, k + block_lanes),
                           hn::LoadU(d, k + 2 * block_lanes), hn::Set(d, bricks.plain));
}

template <class T>
HWY_INLINE void add_stiffness(const BrickCoefficients<T>& bricks, std::size_t begin,
                              std::size_t end, const T* p, T* q)
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
            const auto c = rotated_back(r, load_field(d, corners, lane));
            store_field(d, rotated(r, stiffness_times(d, bricks, block, lane, c)), forces, lane);
        }
        scatter_corners(bricks.scatter + block * 8 * block_lanes, forces, q);
    }
}

void add_stiffness_low(const BrickCoefficients<float>& bricks, std::size_t begin, std::size_t end,
                       const float* p, float* q)
{
    add_stiffness(bricks, begin, end, p, q);
}

void add_stiffness_high(const BrickCoefficients<double>& bricks, std::size_t begin, std::size_t end,
                        const double* p, double* q)
{
    add_stiffness(bricks, begin, end, p, q);
}

// a x b added to s.
template <class V>
HWY_INLINE void add_cross(V a0, V a1, V a2, V b0, V b1, V b2, V& s0, V& s1, V& s2)
{
    s0 = hn::Add(s0, hn::Sub(hn::Mul(a1, b2), hn::Mul(a2, b1)));
    s1 = hn::Add(s1, hn::Sub(hn::Mul(a2, b0), hn::Mul(a0, b2)));
    s2 = hn::Add(s2, hn::Sub(hn::Mul(a0, b1), hn::Mul(a1, b0)));
}

// Adds E to f. `y` holds R^T C, `c` the displacement from rest. A crushed or mirrored cube has no
// definite turning: there E fades out.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void add_turning(D d, double edge, const BrickField<V>& y, const BrickField<V>& c,
                            BrickField<V>& f)
{
    V t0 = hn::Zero(d), t1 = hn::Zero(d), t2 = hn::Zero(d);
    const auto one = [&](V Monomials<V>::*m) HWY_ATTR {
        add_cross(c.of[0].*m, c.of[1].*m, c.of[2].*m, f.of[0].*m, f.of[1].*m, f.of[2].*m, t0, t1,
                  t2);
    };
    one(&Monomials<V>::x), one(&Monomials<V>::y), one(&Monomials<V>::z);
    one(&Monomials<V>::xy), one(&Monomials<V>::yz), one(&Monomials<V>::zx);
    one(&Monomials<V>::xyz);
    // A = tr(S) I - S with S = 4 h at rest, scaled to 2 I there, and its cofactors.
    const V scale = hn::Set(d, 1 / edge), half = hn::Set(d, 0.5 / edge);
    const V s00 = hn::Mul(scale, y.of[0].x), s11 = hn::Mul(scale, y.of[1].y);
    const V s22 = hn::Mul(scale, y.of[2].z);
    const V a00 = hn::Add(s11, s22), a11 = hn::Add(s00, s22), a22 = hn::Add(s00, s11);
    const V a01 = hn::Neg(hn::Mul(half, hn::Add(y.of[0].y, y.of[1].x)));
    const V a02 = hn::Neg(hn::Mul(half, hn::Add(y.of[0].z, y.of[2].x)));
    const V a12 = hn::Neg(hn::Mul(half, hn::Add(y.of[1].z, y.of[2].y)));
    const V c00 = hn::Sub(hn::Mul(a11, a22), hn::Mul(a12, a12));
    const V c01 = hn::Sub(hn::Mul(a02, a12), hn::Mul(a01, a22));
    const V c02 = hn::Sub(hn::Mul(a01, a12), hn::Mul(a02, a11));
    const V c11 = hn::Sub(hn::Mul(a00, a22), hn::Mul(a02, a02));
    const V c12 = hn::Sub(hn::Mul(a01, a02), hn::Mul(a12, a00));
    const V c22 = hn::Sub(hn::Mul(a00, a11), hn::Mul(a01, a01));
    const V det = dot3(a00, c00, a01, c01, a02, c02);
    const V floor = hn::Max(det, hn::Set(d, 0.5));  // 8 at rest
    const V inverse = hn::Mul(scale, hn::Div(hn::Max(det, hn::Zero(d)), hn::Mul(floor, floor)));
    const V q0 = hn::Mul(inverse, dot3(c00, t0, c01, t1, c02, t2));
    const V q1 = hn::Mul(inverse, dot3(c01, t0, c11, t1, c12, t2));
    const V q2 = hn::Mul(inverse, dot3(c02, t0, c12, t1, c22, t2));
    // e_x x q = (0, -q2, q1), e_y x q = (q2, 0, -q0), e_z x q = (-q1, q0, 0)
    f.of[1].x = hn::Sub(f.of[1].x, q2), f.of[2].x = hn::Add(f.of[2].x, q1);
    f.of[0].y = hn::Add(f.of[0].y, q2), f.of[2].y = hn::Sub(f.of[2].y, q0);
    f.of[0].z = hn::Sub(f.of[0].z, q1), f.of[1].z = hn::Add(f.of[1].z, q0);
}

template <class V> HWY_INLINE V field_dot(const BrickField<V>& a, const BrickField<V>& b)
{
    V sum = hn::Mul(a.of[0].x, b.of[0].x);
    for (int i = 0; i < 3; ++i) {
        const Monomials<V>&p = a.of[i], &q = b.of[i];
        if (i > 0) sum = hn::Add(sum, hn::Mul(p.x, q.x));
        sum = hn::Add(sum, hn::Add(hn::Mul(p.y, q.y), hn::Mul(p.z, q.z)));
        sum = hn::Add(sum, hn::Add(hn::Mul(p.xy, q.xy), hn::Mul(p.yz, q.yz)));
        sum = hn::Add(sum, hn::Add(hn::Mul(p.zx, q.zx), hn::Mul(p.xyz, q.xyz)));
    }
    return sum;
}

// Von Mises of the mean stress: strain (C + C^T) / (8 h) of C_x, C_y, C_z.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V von_mises(D d, double h, const BrickField<V>& c, V mu)
{
    const V scale = hn::Mul(mu, hn::Set(d, 1 / (2 * h)));
    const V xx = hn::Mul(scale, c.of[0].x), yy = hn::Mul(scale, c.of[1].y);
    const V zz = hn::Mul(scale, c.of[2].z);
    const V half = hn::Mul(scale, hn::Set(d, 0.5));
    const V xy = hn::Mul(half, hn::Add(c.of[0].y, c.of[1].x));
    const V yz = hn::Mul(half, hn::Add(c.of[1].z, c.of[2].y));
    const V zx = hn::Mul(half, hn::Add(c.of[2].x, c.of[0].z));
    const V a = hn::Sub(xx, yy), b = hn::Sub(yy, zz), e = hn::Sub(zz, xx);
    const V normal = dot3(a, a, b, b, e, e), shear = dot3(xy, xy, yz, yz, zx, zx);
    return hn::Sqrt(hn::Add(hn::Mul(hn::Set(d, 0.5), normal), hn::Mul(hn::Set(d, 3.0), shear)));
}

// Of the matrix with columns scale * (C_x, C_y, C_z).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V determinant(D d, double scale, const BrickField<V>& c)
{
    const V s = hn::Set(d, scale);
    const auto at = [&](int i, V Monomials<V>::*m) HWY_ATTR { return hn::Mul(s, c.of[i].*m); };
    const V x0 = at(0, &Monomials<V>::x), x1 = at(1, &Monomials<V>::x),
            x2 = at(2, &Monomials<V>::x);
    const V y0 = at(0, &Monomials<V>::y), y1 = at(1, &Monomials<V>::y),
            y2 = at(2, &Monomials<V>::y);
    const V z0 = at(0, &Monomials<V>::z), z1 = at(1, &Monomials<V>::z),
            z2 = at(2, &Monomials<V>::z);
    return dot3(x0, hn::Sub(hn::Mul(y1, z2), hn::Mul(y2, z1)), x1,
                hn::Sub(hn::Mul(y2, z0), hn::Mul(y0, z2)), x2,
                hn::Sub(hn::Mul(y0, z1), hn::Mul(y1, z0)));
}

double corotate_all(const BrickCoefficients<double>& bricks, const Corotation& at,
                    std::size_t begin, std::size_t end, const double* x)
{
    const hn::CappedTag<double, block_lanes> d;
    const hn::Rebind<float, decltype(d)> low;
    using V = hn::Vec<decltype(d)>;
    CornerBuffer<double> corners, forces;
    HWY_ALIGN double energies[block_lanes];
    const double edge = 4 * at.h;  // C_x[x] of the cube at rest
    double energy = 0;
    for (std::size_t block = begin; block < end; ++block) {
        gather_corners(bricks.gather + block * 8 * block_lanes, x, corners);
        for (std::size_t lane = 0; lane < block_lanes; lane += hn::Lanes(d)) {
            const auto c = load_field(d, corners, lane);
            V gradient[1][9], rotation[1][4], r[9];
            for (std::size_t i = 0; i < 3; ++i) {
                gradient[0][3 * i] = c.of[i].x;
                gradient[0][3 * i + 1] = c.of[i].y;
                gradient[0][3 * i + 2] = c.of[i].z;
            }
            V(&q)[4] = rotation[0];
            double* quaternion = at.quaternion + block * 4 * block_lanes + lane;
            for (std::size_t k = 0; k < 4; ++k) q[k] = hn::LoadU(d, quaternion + k * block_lanes);
            extract_rotations(d, gradient, rotation);
            for (std::size_t k = 0; k < 4; ++k) {
                hn::StoreU(q[k], d, quaternion + k * block_lanes);
            }
            quaternion_to_matrix(d, q, r);
            for (std::size_t k = 0; k < 9; ++k) {
                const std::size_t to = (block * 9 + k) * block_lanes + lane;
                if (at.rotation) hn::StoreU(r[k], d, at.rotation + to);
                if (at.rotation_low) {
                    hn::StoreU(hn::DemoteTo(low, r[k]), low, at.rotation_low + to);
                }
            }
            const auto y = rotated_back(r, c);
            auto displacement = y;
            const V rest = hn::Set(d, edge);
            displacement.of[0].x = hn::Sub(y.of[0].x, rest);
            displacement.of[1].y = hn::Sub(y.of[1].y, rest);
            displacement.of[2].z = hn::Sub(y.of[2].z, rest);
            auto f = stiffness_times(d, bricks, block, lane, displacement);
            hn::StoreU(field_dot(f, displacement), d, energies + lane);
            if (at.stress) {
                const V mu = hn::LoadU(d, at.material + block * 2 * block_lanes + lane);
                const V stress = von_mises(d, at.h, displacement, mu);
                hn::StoreU(hn::DemoteTo(low, stress), low, at.stress + block * block_lanes + lane);
            }
            if (at.volume) {
                const V change = determinant(d, 1 / edge, y);
                hn::StoreU(hn::DemoteTo(low, change), low, at.volume + block * block_lanes + lane);
            }
            if (at.force) {
                add_turning(d, edge, y, displacement, f);
                store_field(d, rotated(r, f), forces, lane);
            }
        }
        if (at.force) {
            for (double& value : forces.at) value = -value;
            scatter_corners(bricks.scatter + block * 8 * block_lanes, forces, at.force);
        }
        for (const double e : energies) energy += 0.5 * e;
    }
    return energy;
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(add_stiffness_low);
HWY_EXPORT(add_stiffness_high);
HWY_EXPORT(corotate_all);

void add_stiffness_times(const BrickCoefficients<float>& bricks, std::size_t begin, std::size_t end,
                         const float* p, float* q)
{
    HWY_DYNAMIC_DISPATCH(add_stiffness_low)(bricks, begin, end, p, q);
}

void add_stiffness_times(const BrickCoefficients<double>& bricks, std::size_t begin,
                         std::size_t end, const double* p, double* q)
{
    HWY_DYNAMIC_DISPATCH(add_stiffness_high)(bricks, begin, end, p, q);
}

double corotate(const BrickCoefficients<double>& bricks, const Corotation& at, std::size_t begin,
                std::size_t end, const double* x)
{
    return HWY_DYNAMIC_DISPATCH(corotate_all)(bricks, at, begin, end, x);
}

}  // namespace physics
#endif
