#include "physics/lattice/match_slots.hpp"

#include "physics/lattice/region_volume.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/lattice/match_slots.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/math/rotation-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace match_kernel {

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

#if HWY_TARGET == HWY_SCALAR
template <std::size_t quads> HWY_INLINE void load_slots(D d, const float* from, V (&of)[quads][4])
{
    for (std::size_t i = 0; i < 4 * quads; ++i) of[i / 4][i % 4] = hn::LoadU(d, from + i);
}
HWY_INLINE void store_slots(D d, const V (&of)[4][4], float* to)
{
    for (std::size_t i = 0; i < 16; ++i) hn::StoreU(of[i / 4][i % 4], d, to + i);
}
#else
// A quad of each of some slots that lie `apart` floats from each other.
template <class D> HWY_INLINE hn::Vec<D> load_quads(D d, const float* from, std::size_t apart)
{
    if constexpr (hn::MaxLanes(d) <= 4) {
        return hn::LoadU(d, from);
    } else {
        const hn::Half<D> half;
        return hn::Combine(d, load_quads(half, from + apart * hn::MaxLanes(half) / 4, apart),
                           load_quads(half, from, apart));
    }
}
template <class D, class Of>
HWY_INLINE void store_quads(D d, Of quads, float* to, std::size_t apart)
{
    if constexpr (hn::MaxLanes(d) <= 4) {
        hn::StoreU(quads, d, to);
    } else {
        const hn::Half<D> half;
        store_quads(half, hn::LowerHalf(half, quads), to, apart);
        store_quads(half, hn::UpperHalf(half, quads), to + apart * hn::MaxLanes(half) / 4, apart);
    }
}

// Number c of the quad of row r in each group of four lanes becomes number r of that of row c.
HWY_INLINE void transpose(D d, V (&row)[4])
{
    const hn::RepartitionToWide<D> wide;
    const auto pair = [&](V low, V high, V& first, V& second) HWY_ATTR {
        const auto l = hn::BitCast(wide, low), h = hn::BitCast(wide, high);
        first = hn::BitCast(d, hn::InterleaveLower(wide, l, h));
        second = hn::BitCast(d, hn::InterleaveUpper(wide, l, h));
    };
    const V a = hn::InterleaveLower(d, row[0], row[1]), b = hn::InterleaveLower(d, row[2], row[3]);
    const V c = hn::InterleaveUpper(d, row[0], row[1]), e = hn::InterleaveUpper(d, row[2], row[3]);
    pair(a, b, row[0], row[1]);
    pair(c, e, row[2], row[3]);
}

// Quads of numbers, slot by slot, as vectors over slots: of[q][c] is number c of quad q.
template <std::size_t quads> HWY_INLINE void load_slots(D d, const float* from, V (&of)[quads][4])
{
    constexpr std::size_t length = 4 * quads;
    for (std::size_t q = 0; q < quads; ++q) {
        for (std::size_t r = 0; r < 4; ++r) {
            of[q][r] = load_quads(d, from + length * r + 4 * q, 4 * length);
        }
        transpose(d, of[q]);
    }
}

HWY_INLINE void store_slots(D d, V (&of)[4][4], float* to)
{
    for (std::size_t q = 0; q < 4; ++q) {
        transpose(d, of[q]);
        for (std::size_t r = 0; r < 4; ++r) store_quads(d, of[q][r], to + 16 * r + 4 * q, 64);
    }
}

#endif

HWY_INLINE V dot9(const V (&a)[9], const V (&b)[9])
{
    V sum = hn::Mul(a[0], b[0]);
    for (std::size_t i = 1; i < 9; ++i) sum = hn::Add(sum, hn::Mul(a[i], b[i]));
    return sum;
}

// Leaves the cofactors of m in n and returns its determinant.
HWY_INLINE V find_cofactors(const V (&m)[9], V (&n)[9])
{
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = 3 * ((i + 1) % 3), k = 3 * ((i + 2) % 3);
        for (std::size_t c = 0; c < 3; ++c) {
            const std::size_t e = (c + 1) % 3, f = (c + 2) % 3;
            n[3 * i + c] = hn::Sub(hn::Mul(m[j + e], m[k + f]), hn::Mul(m[j + f], m[k + e]));
        }
    }
    return hn::Add(hn::Add(hn::Mul(m[0], n[0]), hn::Mul(m[1], n[1])), hn::Mul(m[2], n[2]));
}

// a times a symmetric matrix, packed as RegionVolume does.
HWY_INLINE void times_root(const V (&a)[9], const V (&volume)[2][4], V (&out)[9])
{
    const V(&q)[4] = volume[0];
    const V root[3][3] = {
        {q[0], q[1], q[2]}, {q[1], q[3], volume[1][0]}, {q[2], volume[1][0], volume[1][1]}};
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            out[3 * i + c] =
                hn::Add(hn::Add(hn::Mul(a[3 * i], root[0][c]), hn::Mul(a[3 * i + 1], root[1][c])),
                        hn::Mul(a[3 * i + 2], root[2][c]));
        }
    }
}

// Leaves G of region_volume.hpp in g.
HWY_INLINE void find_shape(D d, const V (&a)[9], const V (&volume)[2][4], float h, V (&g)[9])
{
    times_root(a, volume, g);
    const V scale = hn::Mul(volume[1][2], hn::Set(d, 1 / h));
    for (V& v : g) v = hn::Mul(scale, v);
}

// Adds `share` of pull_to_rotation() to the rotations r.
HWY_INLINE void resist_stretch(const V (&g)[9], const V (&volume)[2][4], V share, V (&r)[9])
{
    V f[9];
    times_root(g, volume, f);
    for (std::size_t i = 0; i < 9; ++i) {
        r[i] = hn::Add(r[i], hn::Mul(share, hn::Sub(r[i], f[i])));
    }
}

// Adds `share` of pull_to_volume() to the rotations r.
HWY_INLINE void keep_volume(D d, const V (&g)[9], const V (&volume)[2][4], V share, V (&r)[9])
{
    const V one = hn::Set(d, 1.0f);
    V n[9], slope[9], c[3][3];
    const V det = find_cofactors(g, n), size_sq = dot9(g, g);
    const V larger = hn::Mul(hn::Mul(size_sq, size_sq), hn::Set(d, 1.0f / 9));
    const V q = hn::Add(hn::Add(dot9(n, n), larger), hn::Set(d, 2.0f));
    const V away = hn::Div(hn::Sub(det, one), q), away_sq = hn::Mul(away, away);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = i; j < 3; ++j) {
            c[i][j] = c[j][i] = hn::Add(hn::Add(hn::Mul(g[i], g[j]), hn::Mul(g[3 + i], g[3 + j])),
                                        hn::Mul(g[6 + i], g[6 + j]));
        }
    }
    const V size = hn::Mul(size_sq, hn::Set(d, 11.0f / 9));
    for (std::size_t i = 0; i < 9; ++i) {
        const V* const row = g + i / 3 * 3;
        const V(&column)[3] = c[i % 3];
        const V turned = hn::Add(hn::Add(hn::Mul(row[0], column[0]), hn::Mul(row[1], column[1])),
                                 hn::Mul(row[2], column[2]));
        const V stretched = hn::Sub(hn::Mul(size, g[i]), turned);
        slope[i] = hn::Sub(hn::Mul(away, n[i]), hn::Mul(away_sq, stretched));
    }
    times_root(slope, volume, n);
    const auto sane = hn::Lt(q, hn::Set(d, most_stretched));
    const V by = hn::Mul(share, hn::Set(d, -2.0f));
    for (std::size_t i = 0; i < 9; ++i) {
        r[i] = hn::Add(r[i], hn::IfThenElseZero(sane, hn::Mul(by, n[i])));
    }
}

// A vectorful of regions, between their sums and their motions.
template <bool flat> struct Group {
    static constexpr std::size_t quads = flat ? 3 : 4;  // with the moments along axes

    V centre[3], of_mass[3];
    V bent[3], shape[3], less;  // of a plane

    // From sums, leaves A_r row by row in `a`.
    HWY_INLINE void load(D d, const float* slots, const float* twist,
                         const std::array<int, 3>& axes, V (&a)[9])
    {
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
        V s[4][4];
        load_slots(d, slots, s);
        const auto some = hn::Gt(s[0][3], zero);
        const V inverse =
            hn::IfThenElseZero(some, hn::Div(one, hn::IfThenElse(some, s[0][3], one)));

        V column[3][3];
        for (std::size_t k = 0; k < 3; ++k) centre[k] = hn::Mul(inverse, s[0][k]);
        for (std::size_t m = 1; m < quads; ++m) {
            of_mass[m - 1] = hn::Mul(s[m][3], inverse);
            for (std::size_t k = 0; k < 3; ++k) {
                column[m - 1][k] = hn::Sub(s[m][k], hn::Mul(of_mass[m - 1], s[0][k]));
            }
        }
        if constexpr (flat) {
            // (1 - phi) / B P: how far the region is bent like a saddle, and may stay so.
            hn::LoadInterleaved3(d, twist, shape[0], shape[1], shape[2]);
            const V of_twist = hn::Mul(s[3][3], inverse);
            for (std::size_t k = 0; k < 3; ++k) {
                const V twisted = hn::Sub(s[3][k], hn::Mul(of_twist, s[0][k]));
                const V straight =
                    hn::Add(hn::Mul(shape[0], column[0][k]), hn::Mul(shape[1], column[1][k]));
                bent[k] = hn::Mul(shape[2], hn::Sub(twisted, straight));
            }
            less = hn::Sub(of_twist,
                           hn::Add(hn::Mul(shape[0], of_mass[0]), hn::Mul(shape[1], of_mass[1])));
            add_normal(d, column);
        }
        for (std::size_t m = 0; m < 3; ++m) {
            for (std::size_t k = 0; k < 3; ++k) a[3 * k + std::size_t(axes[m])] = column[m][k];
        }
    }

    // Of the maps r of regions, in place of the sums.
    HWY_INLINE void store(D d, const V (&r)[9], const float* weight, const std::array<int, 3>& axes,
                          float h, float* slots) const
    {
        V s[4][4];
        const V w = hn::LoadU(d, weight), size = hn::Set(d, h);
        V moved[3] = {centre[0], centre[1], centre[2]};
        for (std::size_t m = 1; m < quads; ++m) {
            for (std::size_t k = 0; k < 3; ++k) {
                const V along = hn::Mul(size, r[3 * k + std::size_t(axes[m - 1])]);
                moved[k] = hn::Sub(moved[k], hn::Mul(of_mass[m - 1], along));
                if constexpr (flat) {
                    s[m][k] = hn::Mul(w, hn::Sub(along, hn::Mul(shape[m - 1], bent[k])));
                } else {
                    s[m][k] = hn::Mul(w, along);
                }
            }
        }
        if constexpr (flat) {
            for (std::size_t k = 0; k < 3; ++k) {
                moved[k] = hn::Sub(moved[k], hn::Mul(less, bent[k]));
                s[3][k] = hn::Mul(w, bent[k]);
            }
        }
        for (std::size_t k = 0; k < 3; ++k) s[0][k] = hn::Mul(w, moved[k]);
        for (auto& quad : s) quad[3] = hn::Zero(d);
        store_slots(d, s, slots);
    }

private:
    // The normal of a plane, as long as its sides, stands in for the axis without extent.
    static HWY_INLINE void add_normal(D d, V (&column)[3][3])
    {
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
        const V(&a)[3] = column[0];
        const V(&b)[3] = column[1];
        V normal[3];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            normal[k] = hn::Sub(hn::Mul(a[i], b[j]), hn::Mul(a[j], b[i]));
        }
        const V length_sq =
            hn::Add(hn::Add(hn::Mul(normal[0], normal[0]), hn::Mul(normal[1], normal[1])),
                    hn::Mul(normal[2], normal[2]));
        const auto has_length = hn::Gt(length_sq, zero);
        const V length = hn::Sqrt(hn::IfThenElse(has_length, length_sq, one));
        const V scale = hn::IfThenElseZero(has_length, hn::Div(hn::Sqrt(length), length));
        for (std::size_t k = 0; k < 3; ++k) column[2][k] = hn::Mul(scale, normal[k]);
    }
};

// Groups whose rotations are found side by side.
inline constexpr std::size_t at_once = 2;

// The slots from i on.
HWY_INLINE MatchedSlots slots_from(const MatchedSlots& of, std::size_t i)
{
    MatchedSlots out = of;
    out.slots += 16 * i;
    out.weight += i;
    out.rotation += 4 * i;
    if (of.twist) out.twist += 3 * i;
    if (of.volume) out.volume += 8 * i, out.volume_share += i;
    if (of.stretch_share) out.stretch_share += i;
    return out;
}

template <bool flat> HWY_INLINE void match_groups(D d, const MatchedSlots& of)
{
    const std::size_t lanes = hn::Lanes(d);
    Group<flat> group[at_once];
    V a[at_once][9], q[at_once][4];
    for (std::size_t g = 0; g < at_once; ++g) {
        const MatchedSlots own = slots_from(of, g * lanes);
        group[g].load(d, own.slots, own.twist, of.axes, a[g]);
        hn::LoadInterleaved4(d, own.rotation, q[g][0], q[g][1], q[g][2], q[g][3]);
    }
    extract_rotations(d, a, q);
    for (std::size_t g = 0; g < at_once; ++g) {
        const MatchedSlots own = slots_from(of, g * lanes);
        hn::StoreInterleaved4(q[g][0], q[g][1], q[g][2], q[g][3], d, own.rotation);
        V r[9];
        quaternion_to_matrix(d, q[g], r);
        if (!flat && of.volume) {
            V volume[2][4], shape[9];
            load_slots(d, own.volume, volume);
            find_shape(d, a[g], volume, of.h, shape);
            if (of.stretch_share) {
                resist_stretch(shape, volume, hn::LoadU(d, own.stretch_share), r);
            }
            keep_volume(d, shape, volume, hn::LoadU(d, own.volume_share), r);
        }
        group[g].store(d, r, own.weight, of.axes, of.h, own.slots);
    }
}

template <bool flat> void match_all(const MatchedSlots& of)
{
    const D d;
    constexpr std::size_t most = at_once * hn::MaxLanes(D());
    const std::size_t length = at_once * hn::Lanes(d);
    std::size_t i = 0;
    for (; i + length <= of.count; i += length) match_groups<flat>(d, slots_from(of, i));
    if (i == of.count) return;
    HWY_ALIGN float some[16 * most] = {};
    HWY_ALIGN float w[most] = {};
    HWY_ALIGN float shape[3 * most] = {};
    HWY_ALIGN float q[4 * most] = {};
    HWY_ALIGN float volume[8 * most] = {};
    HWY_ALIGN float share[most] = {};
    HWY_ALIGN float stretch[most] = {};
    const std::size_t rest = of.count - i;
    const MatchedSlots last = slots_from(of, i);
    std::copy_n(last.slots, 16 * rest, some);
    std::copy_n(last.weight, rest, w);
    std::copy_n(last.rotation, 4 * rest, q);
    if (of.twist) std::copy_n(last.twist, 3 * rest, shape);
    if (of.volume) {
        std::copy_n(last.volume, 8 * rest, volume);
        std::copy_n(last.volume_share, rest, share);
    }
    if (of.stretch_share) std::copy_n(last.stretch_share, rest, stretch);
    MatchedSlots few = of;
    few.count = rest;
    few.slots = some;
    few.weight = w;
    few.rotation = q;
    if (of.twist) few.twist = shape;
    if (of.volume) few.volume = volume, few.volume_share = share;
    if (of.stretch_share) few.stretch_share = stretch;
    match_groups<flat>(d, few);
    std::copy_n(some, 16 * rest, last.slots);
    std::copy_n(q, 4 * rest, last.rotation);
}

}  // namespace match_kernel

void match_slots_of(const MatchedSlots& of)
{
    if (of.twist) {
        match_kernel::match_all<true>(of);
    } else {
        match_kernel::match_all<false>(of);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(match_slots_of);

void match_slots(const MatchedSlots& of)
{
    HWY_DYNAMIC_DISPATCH(match_slots_of)(of);
}

}  // namespace physics
#endif
