// The rotational part of 3x3 and 2x2 matrices, one matrix a SIMD lane. Included once for each
// Highway target by the kernels that fuse it with other work (see rotation.cpp for the plain way).
//
// Wanted: the rotation R nearest to A, which maximises f(R) = tr(R^T A). With the unit quaternion q
// of R, f = q^T K q for a symmetric, traceless 4x4 matrix K of the entries of A (Horn. Closed-form
// solution of absolute orientation using unit quaternions. JOSA A 1987). So f has one maximum (up
// to sign), the top eigenvector of K; every other stationary point is a saddle or the minimum.
//
// Around the present q, with B = R^T A and S = (B + B^T)/2, K is
//   [ tr B   z^T            ]     z = (B21 - B12, B02 - B20, B10 - B01)
//   [ z      2S - (tr B) I  ]     2H = (tr B) I - (2S - (tr B) I),  H = tr(S) I - S
// Newton's step on f in the chart q <- q (1, t)/|.| is 2H t = z. It is a Rayleigh quotient
// iteration too, so it converges cubically: from 0.1 rad two steps reach 1e-9. (Mueller, Bender,
// Chentanez, Macklin. A robust method to extract the rotational part of deformations. MIG 2016, use
// tr(S) I in place of H: linear convergence.) H > 0 at a stationary point proves it the maximum.
// Where H is not positive definite or the step is long, the lane takes q from the top eigenspace of
// K itself: a high power of K + c I by squaring, applied to the previous q. So where many rotations
// are equally near (rank 0 or 1, some mirrored matrices), the one nearest to the previous is taken,
// and nothing jumps in time.
//
// Lanes never mix, and only operations that IEEE 754 rounds exactly are used (no fused
// multiply-add): a matrix gives the same bits in any lane, on any target.

#if defined(PHYSICS_ROTATION_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef PHYSICS_ROTATION_INL_HPP
#undef PHYSICS_ROTATION_INL_HPP
#else
#define PHYSICS_ROTATION_INL_HPP
#endif

#include <hwy/highway.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

template <class T> struct RotationTolerance;
template <> struct RotationTolerance<float> {
    static constexpr float damping = 2e-5f;    // added to H, of the matrix's size: an undetermined
                                               // turn stays as it was instead of following noise
    static constexpr float last_step = 2e-3f;  // |t| below which the step's own error, |t|^3, is
                                               // below rounding
    // of K + c I: eigenvalues part when they differ by more than 2^-squarings of the matrix's size,
    // which has to be coarser than rounding
    static constexpr int squarings = 16;
    static constexpr float nearly_unit = 4e-3f;  // |q|^2 - 1 whose cube is below rounding
    static constexpr float smallest = 1e-34f;    // a matrix with no entry above is taken for zero
};
template <> struct RotationTolerance<double> {
    static constexpr double damping = 1e-12;
    static constexpr int squarings = 34;
    static constexpr double last_step = 5e-6;
    static constexpr double nearly_unit = 5e-6;
    static constexpr double smallest = 1e-290;
};

// R, row by row, of the unit quaternion q = (w, x, y, z).
template <class D, class V = hn::Vec<D>>
HWY_INLINE void quaternion_to_matrix(D d, const V (&q)[4], V (&r)[9])
{
    const V one = hn::Set(d, hn::TFromD<D>(1));
    const V x2 = hn::Add(q[1], q[1]), y2 = hn::Add(q[2], q[2]), z2 = hn::Add(q[3], q[3]);
    const V wx = hn::Mul(q[0], x2), wy = hn::Mul(q[0], y2), wz = hn::Mul(q[0], z2);
    const V xx = hn::Mul(q[1], x2), xy = hn::Mul(q[1], y2), xz = hn::Mul(q[1], z2);
    const V yy = hn::Mul(q[2], y2), yz = hn::Mul(q[2], z2), zz = hn::Mul(q[3], z2);
    r[0] = hn::Sub(one, hn::Add(yy, zz));
    r[1] = hn::Sub(xy, wz);
    r[2] = hn::Add(xz, wy);
    r[3] = hn::Add(xy, wz);
    r[4] = hn::Sub(one, hn::Add(xx, zz));
    r[5] = hn::Sub(yz, wx);
    r[6] = hn::Sub(xz, wy);
    r[7] = hn::Add(yz, wx);
    r[8] = hn::Sub(one, hn::Add(xx, yy));
}

namespace rotation_detail {

template <class D, class V> HWY_INLINE V dot4(D, const V (&a)[4], const V (&b)[4])
{
    return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])),
                   hn::Add(hn::Mul(a[2], b[2]), hn::Mul(a[3], b[3])));
}

template <class D, class V> HWY_INLINE void normalise(D d, V (&q)[4])
{
    using T = hn::TFromD<D>;
    // What is nearly unit is scaled by 1 - e/2 + 3 e^2 / 8 in place of 1 / sqrt(1 + e): no root and
    // no division to wait for.
    const V one = hn::Set(d, T(1)), size_sq = dot4(d, q, q), e = hn::Sub(size_sq, one);
    const auto near = hn::Lt(hn::Abs(e), hn::Set(d, RotationTolerance<T>::nearly_unit));
    const V bend = hn::Mul(hn::Set(d, T(0.375)), e);
    V scale = hn::Add(one, hn::Mul(e, hn::Sub(bend, hn::Set(d, T(0.5)))));
    if (HWY_UNLIKELY(!hn::AllTrue(d, near))) {
        scale = hn::IfThenElse(near, scale, hn::Div(one, hn::Sqrt(size_sq)));
    }
    for (V& c : q) c = hn::Mul(c, scale);
}

// One Newton step from q: the step t, and whether H is positive definite there.
template <class D, class V>
HWY_INLINE auto newton_step(D d, const V (&a)[9], const V (&q)[4], V (&t)[3])
{
    using T = hn::TFromD<D>;
    V r[9];
    quaternion_to_matrix(d, q, r);
    V b[9];  // R^T A
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            b[3 * i + j] = hn::Add(hn::Add(hn::Mul(r[i], a[j]), hn::Mul(r[3 + i], a[3 + j])),
                                   hn::Mul(r[6 + i], a[6 + j]));
        }
    }
    const V damping = hn::Set(d, 2 * RotationTolerance<T>::damping);
    const V z0 = hn::Sub(b[7], b[5]), z1 = hn::Sub(b[2], b[6]), z2 = hn::Sub(b[3], b[1]);
    // 2H and its cofactors
    const V s01 = hn::Neg(hn::Add(b[1], b[3])), s02 = hn::Neg(hn::Add(b[2], b[6]));
    const V s12 = hn::Neg(hn::Add(b[5], b[7]));
    const V h00 = hn::Add(hn::Add(b[4], b[8]), hn::Add(hn::Add(b[4], b[8]), damping));
    const V h11 = hn::Add(hn::Add(b[0], b[8]), hn::Add(hn::Add(b[0], b[8]), damping));
    const V h22 = hn::Add(hn::Add(b[0], b[4]), hn::Add(hn::Add(b[0], b[4]), damping));
    const V c00 = hn::Sub(hn::Mul(h11, h22), hn::Mul(s12, s12));
    const V c01 = hn::Sub(hn::Mul(s02, s12), hn::Mul(s01, h22));
    const V c02 = hn::Sub(hn::Mul(s01, s12), hn::Mul(s02, h11));
    const V c11 = hn::Sub(hn::Mul(h00, h22), hn::Mul(s02, s02));
    const V c12 = hn::Sub(hn::Mul(s01, s02), hn::Mul(s12, h00));
    const V c22 = hn::Sub(hn::Mul(h00, h11), hn::Mul(s01, s01));
    const V det = hn::Add(hn::Add(hn::Mul(h00, c00), hn::Mul(s01, c01)), hn::Mul(s02, c02));
    const V zero = hn::Zero(d);
    const auto definite = hn::And(hn::And(hn::Gt(h00, zero), hn::Gt(c22, zero)), hn::Gt(det, zero));
    const V inverse = hn::Div(hn::Set(d, T(1)), det);
    t[0] = hn::Mul(inverse, hn::Add(hn::Add(hn::Mul(c00, z0), hn::Mul(c01, z1)), hn::Mul(c02, z2)));
    t[1] = hn::Mul(inverse, hn::Add(hn::Add(hn::Mul(c01, z0), hn::Mul(c11, z1)), hn::Mul(c12, z2)));
    t[2] = hn::Mul(inverse, hn::Add(hn::Add(hn::Mul(c02, z0), hn::Mul(c12, z1)), hn::Mul(c22, z2)));
    return definite;
}

// q (1, t), normalised.
template <class D, class V> HWY_INLINE void turn(D d, const V (&q)[4], const V (&t)[3], V (&out)[4])
{
    out[0] = hn::Sub(
        q[0], hn::Add(hn::Add(hn::Mul(q[1], t[0]), hn::Mul(q[2], t[1])), hn::Mul(q[3], t[2])));
    out[1] = hn::Add(
        q[1], hn::Add(hn::Mul(q[0], t[0]), hn::Sub(hn::Mul(q[2], t[2]), hn::Mul(q[3], t[1]))));
    out[2] = hn::Add(
        q[2], hn::Add(hn::Mul(q[0], t[1]), hn::Sub(hn::Mul(q[3], t[0]), hn::Mul(q[1], t[2]))));
    out[3] = hn::Add(
        q[3], hn::Add(hn::Mul(q[0], t[2]), hn::Sub(hn::Mul(q[1], t[1]), hn::Mul(q[2], t[0]))));
    normalise(d, out);
}

template <class D, std::size_t some> struct Masks {
    hn::Mask<D> of[some];

    HWY_INLINE hn::Mask<D> any() const
    {
        auto any = of[0];
        for (std::size_t g = 1; g < some; ++g) any = hn::Or(any, of[g]);
        return any;
    }
};

// Newton steps on the lanes of `active` until they settle. Returns the lanes that did not: they met
// an indefinite H or a long step, or still take sizeable ones after `limit`.
template <class D, class V, std::size_t some>
HWY_INLINE Masks<D, some> settle(D d, const V (&a)[some][9], V (&q)[some][4], Masks<D, some> active,
                                 int limit)
{
    using T = hn::TFromD<D>;
    const V last_sq = hn::Set(d, RotationTolerance<T>::last_step * RotationTolerance<T>::last_step);
    Masks<D, some> lost;
    for (auto& m : lost.of) m = hn::MaskFromVec(hn::Zero(d));
    for (int i = 1; i <= limit; ++i) {
        // An undetermined turn may jitter by rounding / damping for ever, and that is fine.
        const V longest_sq = hn::Set(d, i < limit ? T(1) : T(1e-3));
        V t[some][3];
        Masks<D, some> definite;
        for (std::size_t g = 0; g < some; ++g) definite.of[g] = newton_step(d, a[g], q[g], t[g]);
        for (std::size_t g = 0; g < some; ++g) {
            const V t_sq = hn::Add(hn::Add(hn::Mul(t[g][0], t[g][0]), hn::Mul(t[g][1], t[g][1])),
                                   hn::Mul(t[g][2], t[g][2]));
            const auto good = hn::And(definite.of[g], hn::Lt(t_sq, longest_sq));
            lost.of[g] = hn::Or(lost.of[g], hn::AndNot(good, active.of[g]));
            active.of[g] = hn::And(active.of[g], good);
            V next[4];
            turn(d, q[g], t[g], next);
            for (int k = 0; k < 4; ++k) q[g][k] = hn::IfThenElse(active.of[g], next[k], q[g][k]);
            active.of[g] = hn::AndNot(hn::Lt(t_sq, last_sq), active.of[g]);
        }
        if (hn::AllFalse(d, active.any())) break;
    }
    return lost;
}

// The part of q in the top eigenspace of K, normalised; where there is next to none, that
// eigenspace's largest column.
template <class D, class V> HWY_INLINE void project_on_top(D d, const V (&a)[9], V (&q)[4])
{
    using T = hn::TFromD<D>;
    // K + c I with c >= every |eigenvalue|: entries are at most 1, so |A|_F <= 3 and
    // |eigenvalue| <= sqrt(3) |A|_F.
    V sum = hn::Zero(d);
    for (const V& entry : a) sum = hn::Add(sum, hn::Mul(entry, entry));
    const V c = hn::Add(hn::Sqrt(hn::Mul(hn::Set(d, T(3)), sum)), hn::Set(d, T(1e-6)));
    V m[10];  // 00 01 02 03 11 12 13 22 23 33
    m[0] = hn::Add(c, hn::Add(hn::Add(a[0], a[4]), a[8]));
    m[1] = hn::Sub(a[7], a[5]);
    m[2] = hn::Sub(a[2], a[6]);
    m[3] = hn::Sub(a[3], a[1]);
    m[4] = hn::Add(c, hn::Sub(hn::Sub(a[0], a[4]), a[8]));
    m[5] = hn::Add(a[1], a[3]);
    m[6] = hn::Add(a[2], a[6]);
    m[7] = hn::Add(c, hn::Sub(hn::Sub(a[4], a[0]), a[8]));
    m[8] = hn::Add(a[5], a[7]);
    m[9] = hn::Add(c, hn::Sub(hn::Sub(a[8], a[0]), a[4]));
    constexpr int at[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
    for (int squaring = 0; squaring < RotationTolerance<T>::squarings; ++squaring) {
        const V trace = hn::Add(hn::Add(m[0], m[4]), hn::Add(m[7], m[9]));
        const V scale = hn::Div(hn::Set(d, T(1)), trace);
        for (V& entry : m) entry = hn::Mul(entry, scale);
        V sq[10];
        for (int i = 0; i < 4; ++i) {
            for (int j = i; j < 4; ++j) {
                V s = hn::Mul(m[at[i][0]], m[at[0][j]]);
                for (int k = 1; k < 4; ++k) s = hn::Add(s, hn::Mul(m[at[i][k]], m[at[k][j]]));
                sq[at[i][j]] = s;
            }
        }
        for (int k = 0; k < 10; ++k) m[k] = sq[k];
    }
    V largest[4], projected[4];
    V diagonal = m[0];
    for (int i = 0; i < 4; ++i) largest[i] = m[at[0][i]];
    for (int j = 1; j < 4; ++j) {
        const auto larger = hn::Gt(m[at[j][j]], diagonal);
        diagonal = hn::IfThenElse(larger, m[at[j][j]], diagonal);
        for (int i = 0; i < 4; ++i) largest[i] = hn::IfThenElse(larger, m[at[i][j]], largest[i]);
    }
    for (int i = 0; i < 4; ++i) {
        V s = hn::Mul(m[at[i][0]], q[0]);
        for (int k = 1; k < 4; ++k) s = hn::Add(s, hn::Mul(m[at[i][k]], q[k]));
        projected[i] = s;
    }
    const V size_sq = hn::Mul(diagonal, diagonal);
    const auto orthogonal =
        hn::Lt(dot4(d, projected, projected), hn::Mul(hn::Set(d, T(1e-6)), size_sq));
    for (int i = 0; i < 4; ++i) q[i] = hn::IfThenElse(orthogonal, largest[i], projected[i]);
    normalise(d, q);
}

// Scales A so that its largest entry is 1; zero or not finite becomes the zero matrix. Replaces a q
// that is no quaternion by the identity, and makes it unit.
template <class D, class V> HWY_INLINE void make_safe(D d, V (&a)[9], V (&q)[4])
{
    using T = hn::TFromD<D>;
    const V zero = hn::Zero(d), one = hn::Set(d, T(1));
    V largest = hn::Abs(a[0]);
    V total = largest;  // NaN and infinity show up in a sum, not always in a maximum
    for (int k = 1; k < 9; ++k) {
        const V size = hn::Abs(a[k]);
        total = hn::Add(total, size);
        largest = hn::Max(largest, size);
    }
    const auto sane = hn::And(hn::Gt(total, hn::Set(d, RotationTolerance<T>::smallest)),
                              hn::Lt(total, hn::Set(d, std::numeric_limits<T>::max())));
    const V scale = hn::Div(one, hn::IfThenElse(sane, largest, one));
    for (V& entry : a) entry = hn::IfThenElseZero(sane, hn::Mul(entry, scale));

    const V norm_sq = dot4(d, q, q);
    const auto usable =
        hn::And(hn::Gt(norm_sq, hn::Set(d, T(1e-6))), hn::Lt(norm_sq, hn::Set(d, T(1e6))));
    q[0] = hn::IfThenElse(usable, q[0], one);
    for (int k = 1; k < 4; ++k) q[k] = hn::IfThenElse(usable, q[k], zero);
    normalise(d, q);
}

// Of the lanes that are lost, q from the top eigenspace of K next to where they started.
template <class D, class V, std::size_t some>
HWY_NOINLINE void start_from_top(D d, const V (&a)[some][9], V (&start)[some][4],
                                 const Masks<D, some>& lost, V (&q)[some][4])
{
    for (std::size_t g = 0; g < some; ++g) project_on_top(d, a[g], start[g]);
    settle(d, a, start, lost, 3);
    for (std::size_t g = 0; g < some; ++g) {
        for (int k = 0; k < 4; ++k) q[g][k] = hn::IfThenElse(lost.of[g], start[g][k], q[g][k]);
    }
}

}  // namespace rotation_detail

// Turns q, the rotation found last time (or zeros: none), into that of `matrix` (row by row). Any
// input gives a unit quaternion: a zero matrix or one that is not finite leaves q as it was. Each
// is a long chain of operations that wait for the one before: two side by side take little longer
// than one.
template <class D, class V = hn::Vec<D>, std::size_t some>
HWY_INLINE void extract_rotations(D d, const V (&matrix)[some][9], V (&q)[some][4])
{
    namespace detail = rotation_detail;
    V a[some][9], start[some][4];
    detail::Masks<D, some> all;
    for (std::size_t g = 0; g < some; ++g) {
        for (int k = 0; k < 9; ++k) a[g][k] = matrix[g][k];
        detail::make_safe(d, a[g], q[g]);
        for (int k = 0; k < 4; ++k) start[g][k] = q[g][k];
        all.of[g] = hn::Eq(a[g][0], a[g][0]);
    }
    const auto lost = detail::settle(d, a, q, all, 6);
    if (HWY_UNLIKELY(!hn::AllFalse(d, lost.any()))) detail::start_from_top(d, a, start, lost, q);
}

// The same in 2D, in closed form: (cos, sin) of the rotation nearest to [a0 a1; a2 a3]. Where all
// rotations are equally near, (cos, sin) stays; a pair that is no direction becomes (1, 0).
template <class D, class V = hn::Vec<D>>
HWY_INLINE void extract_rotation_2d(D d, const V (&a)[4], V& cosine, V& sine)
{
    using T = hn::TFromD<D>;
    const V one = hn::Set(d, T(1));
    const auto unit = [&](V c, V s, V c_else, V s_else, V& c_out, V& s_out) {
        const V size = hn::Max(hn::Abs(c), hn::Abs(s));
        const V total = hn::Add(hn::Abs(c), hn::Abs(s));
        const auto sane = hn::And(hn::Gt(total, hn::Set(d, RotationTolerance<T>::smallest)),
                                  hn::Lt(total, hn::Set(d, std::numeric_limits<T>::max())));
        const V scale = hn::Div(one, hn::IfThenElse(sane, size, one));
        const V cs = hn::IfThenElse(sane, hn::Mul(c, scale), one);
        const V ss = hn::IfThenElse(sane, hn::Mul(s, scale), one);
        const V norm = hn::Sqrt(hn::Add(hn::Mul(cs, cs), hn::Mul(ss, ss)));
        c_out = hn::IfThenElse(sane, hn::Div(cs, norm), c_else);
        s_out = hn::IfThenElse(sane, hn::Div(ss, norm), s_else);
    };
    V c_before, s_before;
    unit(cosine, sine, one, hn::Zero(d), c_before, s_before);
    unit(hn::Add(a[0], a[3]), hn::Sub(a[2], a[1]), c_before, s_before, cosine, sine);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#endif
