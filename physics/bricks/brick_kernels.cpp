#include "physics/bricks/brick_kernels.hpp"

// Map: products with K; turning, stress and volume; corotation; dispatch. What they are made of
// stands in brick_kernels-inl.hpp.

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/bricks/brick_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/bricks/brick_kernels-inl.hpp"
#include "physics/math/rotation-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

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
            auto f = stiffness_times(d, bricks, block, lane, c);
            subtract_excess(d, bricks, block, lane, c, f);
            store_field(d, rotated(r, f), forces, lane);
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

void add_excess_high(const BrickCoefficients<double>& bricks, std::size_t begin, std::size_t end,
                     const double* p, double* q)
{
    const hn::CappedTag<double, block_lanes> d;
    CornerBuffer<double> corners, momenta;
    for (std::size_t block = begin; block < end; ++block) {
        gather_corners(bricks.gather + block * 8 * block_lanes, p, corners);
        for (std::size_t lane = 0; lane < block_lanes; lane += hn::Lanes(d)) {
            const auto c = load_field(d, corners, lane);
            store_field(d, excess_times(d, bricks, block, lane, c), momenta, lane);
        }
        scatter_corners(bricks.scatter + block * 8 * block_lanes, momenta, q);
    }
}

// How R turns with a cube: q, and (tr(S) I - S)^-1 as xx xy xz yy yz zz.
template <class V> struct Turning {
    V q[3], inverse[6];
};

// Adds E to f. `y` holds R^T C, `c` the displacement from the cube. A crushed or mirrored cube has
// no definite turning: there E fades out, and what is returned is 0. It is where `held` is not null
// and 1: R does not turn.
template <class D, class V = hn::Vec<D>>
HWY_INLINE Turning<V> add_turning(D d, double edge, const double* held, const BrickField<V>& y,
                                  const BrickField<V>& c, BrickField<V>& f)
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
    V det = dot3(a00, c00, a01, c01, a02, c02);
    if (held) det = hn::IfThenZeroElse(hn::Gt(hn::LoadU(d, held), hn::Zero(d)), det);
    const V floor = hn::Max(det, hn::Set(d, 0.5));  // 8 at rest
    const V inverse = hn::Mul(scale, hn::Div(hn::Max(det, hn::Zero(d)), hn::Mul(floor, floor)));
    const V q0 = hn::Mul(inverse, dot3(c00, t0, c01, t1, c02, t2));
    const V q1 = hn::Mul(inverse, dot3(c01, t0, c11, t1, c12, t2));
    const V q2 = hn::Mul(inverse, dot3(c02, t0, c12, t1, c22, t2));
    // e_x x q = (0, -q2, q1), e_y x q = (q2, 0, -q0), e_z x q = (-q1, q0, 0)
    f.of[1].x = hn::Sub(f.of[1].x, q2), f.of[2].x = hn::Add(f.of[2].x, q1);
    f.of[0].y = hn::Add(f.of[0].y, q2), f.of[2].y = hn::Sub(f.of[2].y, q0);
    f.of[0].z = hn::Sub(f.of[0].z, q1), f.of[1].z = hn::Add(f.of[1].z, q0);
    const auto definite = hn::Ge(det, hn::Set(d, 0.5));
    const auto kept = [&](V v) HWY_ATTR { return hn::IfThenElseZero(definite, v); };
    const auto of = [&](V cofactor) HWY_ATTR { return kept(hn::Mul(inverse, cofactor)); };
    return {{kept(q0), kept(q1), kept(q2)}, {of(c00), of(c01), of(c02), of(c11), of(c12), of(c22)}};
}

// The rows of strained_rows that a cube's second derivative is made of: the field of displacements,
// then how R turns.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void store_strained(D d, const BrickField<V>& displacement, const Turning<V>& turning,
                               double* high, float* low)
{
    const hn::Rebind<float, D> d_low;
    const auto one = [&](V v) HWY_ATTR {
        hn::StoreU(v, d, high);
        hn::StoreU(hn::DemoteTo(d_low, v), d_low, low);
        high += block_lanes, low += block_lanes;
    };
    for (const Monomials<V>& m : displacement.of) {
        one(m.x), one(m.y), one(m.z), one(m.xy), one(m.yz), one(m.zx), one(m.xyz);
    }
    for (const V& v : turning.inverse) one(v);
    for (const V& v : turning.q) one(v);
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

// R of the mean deformation gradient in C, from the quaternion of last time, which it replaces; but
// where `held` is not null and 1, that of last time.
template <class D, class V = hn::Vec<D>>
HWY_INLINE void find_rotation(D d, const BrickField<V>& c, const double* held, double* quaternion,
                              V (&r)[9])
{
    V gradient[1][9], rotation[1][4];
    for (std::size_t i = 0; i < 3; ++i) {
        gradient[0][3 * i] = c.of[i].x;
        gradient[0][3 * i + 1] = c.of[i].y;
        gradient[0][3 * i + 2] = c.of[i].z;
    }
    V(&q)[4] = rotation[0];
    for (std::size_t k = 0; k < 4; ++k) q[k] = hn::LoadU(d, quaternion + k * block_lanes);
    extract_rotations(d, gradient, rotation);
    if (held) {
        const auto keeps = hn::Gt(hn::LoadU(d, held), hn::Zero(d));
        for (std::size_t k = 0; k < 4; ++k) {
            q[k] = hn::IfThenElse(keeps, hn::LoadU(d, quaternion + k * block_lanes), q[k]);
        }
    }
    for (std::size_t k = 0; k < 4; ++k) hn::StoreU(q[k], d, quaternion + k * block_lanes);
    quaternion_to_matrix(d, q, r);
}

// The lanes from `lane` on of one block with the field C: fills what is wanted of `at`, and
// `forces` with the elastic forces' opposites. Returns twice the energies.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V corotate_lanes(D d, const BrickCoefficients<double>& bricks, const Corotation& at,
                            std::size_t block, std::size_t lane, const BrickField<V>& c,
                            CornerBuffer<double>& forces)
{
    const hn::Rebind<float, D> low;
    const double edge = 4 * at.h;  // C_x[x] of the cube at rest
    const std::size_t row = block * block_lanes + lane;
    V r[9];
    const double* held = at.held ? at.held + row : nullptr;
    find_rotation(d, c, held, at.quaternion + block * 4 * block_lanes + lane, r);
    for (std::size_t k = 0; k < 9; ++k) {
        const std::size_t to = (block * 9 + k) * block_lanes + lane;
        if (at.rotation) hn::StoreU(r[k], d, at.rotation + to);
        if (at.rotation_low) hn::StoreU(hn::DemoteTo(low, r[k]), low, at.rotation_low + to);
    }
    const auto y = rotated_back(r, c);
    auto displacement = y;
    const V rest = hn::Set(d, edge);
    displacement.of[0].x = hn::Sub(y.of[0].x, rest);
    displacement.of[1].y = hn::Sub(y.of[1].y, rest);
    displacement.of[2].z = hn::Sub(y.of[2].z, rest);
    auto elastic = displacement;
    if (at.plastic) {
        const double* rows = at.plastic + block * plastic_rows * block_lanes + lane;
        elastic = without_plastic(d, rows, displacement);
    }
    auto f = stiffness_times(d, bricks, block, lane, elastic);
    const V energy = field_dot(f, elastic);
    if (at.stress) {
        const V mu = hn::LoadU(d, at.material + block * 2 * block_lanes + lane);
        const V stress = von_mises(d, at.h, elastic, mu);
        hn::StoreU(hn::DemoteTo(low, stress), low, at.stress + row);
    }
    if (at.volume) {
        const V change = determinant(d, 1 / edge, y);
        hn::StoreU(hn::DemoteTo(low, change), low, at.volume + row);
    }
    if (at.energy) {
        const V own = hn::Mul(hn::Set(d, 0.5), energy);
        hn::StoreU(hn::DemoteTo(low, own), low, at.energy + row);
    }
    if (at.force) {
        const auto turning = add_turning(d, edge, held, y, displacement, f);
        if (at.strained) {
            const std::size_t to = block * strained_rows * block_lanes + lane;
            store_strained(d, displacement, turning, at.strained + to, at.strained_low + to);
        }
        store_field(d, rotated(r, f), forces, lane);
    }
    return energy;
}

double corotate_all(const BrickCoefficients<double>& bricks, const Corotation& at,
                    std::size_t begin, std::size_t end, const double* x)
{
    const hn::CappedTag<double, block_lanes> d;
    CornerBuffer<double> corners, forces;
    HWY_ALIGN double energies[block_lanes];
    double energy = 0;
    for (std::size_t block = begin; block < end; ++block) {
        gather_corners(bricks.gather + block * 8 * block_lanes, x, corners);
        for (std::size_t lane = 0; lane < block_lanes; lane += hn::Lanes(d)) {
            const auto c = load_field(d, corners, lane);
            hn::StoreU(corotate_lanes(d, bricks, at, block, lane, c, forces), d, energies + lane);
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
HWY_EXPORT(add_excess_high);
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

void add_excess_times(const BrickCoefficients<double>& bricks, std::size_t begin, std::size_t end,
                      const double* p, double* q)
{
    HWY_DYNAMIC_DISPATCH(add_excess_high)(bricks, begin, end, p, q);
}

double corotate(const BrickCoefficients<double>& bricks, const Corotation& at, std::size_t begin,
                std::size_t end, const double* x)
{
    return HWY_DYNAMIC_DISPATCH(corotate_all)(bricks, at, begin, end, x);
}

}  // namespace physics
#endif
