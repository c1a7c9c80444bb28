#include "physics/lattice/match_slots.hpp"

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
HWY_INLINE void load_slots(D d, const float* from, V (&of)[4][4])
{
    for (std::size_t i = 0; i < 16; ++i) of[i / 4][i % 4] = hn::LoadU(d, from + i);
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
HWY_INLINE void load_slots(D d, const float* from, V (&of)[4][4])
{
    for (std::size_t q = 0; q < 4; ++q) {
        for (std::size_t r = 0; r < 4; ++r) of[q][r] = load_quads(d, from + 16 * r + 4 * q, 64);
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

    // Of rotations q, in place of the sums.
    HWY_INLINE void store(D d, const V (&q)[4], const float* weight, const std::array<int, 3>& axes,
                          float h, float* slots) const
    {
        V s[4][4], r[9];
        quaternion_to_matrix(d, q, r);
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

template <bool flat>
HWY_INLINE void match_groups(D d, float* slots, const float* weight, const float* twist,
                             float* rotation, const std::array<int, 3>& axes, float h)
{
    const std::size_t lanes = hn::Lanes(d);
    Group<flat> group[at_once];
    V a[at_once][9], q[at_once][4];
    for (std::size_t g = 0; g < at_once; ++g) {
        const std::size_t i = g * lanes;
        group[g].load(d, slots + 16 * i, flat ? twist + 3 * i : nullptr, axes, a[g]);
        hn::LoadInterleaved4(d, rotation + 4 * i, q[g][0], q[g][1], q[g][2], q[g][3]);
    }
    extract_rotations(d, a, q);
    for (std::size_t g = 0; g < at_once; ++g) {
        const std::size_t i = g * lanes;
        hn::StoreInterleaved4(q[g][0], q[g][1], q[g][2], q[g][3], d, rotation + 4 * i);
        group[g].store(d, q[g], weight + i, axes, h, slots + 16 * i);
    }
}

template <bool flat>
void match_all(std::size_t count, float* slots, const float* weight, const float* twist,
               float* rotation, const std::array<int, 3>& axes, float h)
{
    const D d;
    constexpr std::size_t most = at_once * hn::MaxLanes(D());
    const std::size_t length = at_once * hn::Lanes(d);
    std::size_t i = 0;
    for (; i + length <= count; i += length) {
        match_groups<flat>(d, slots + 16 * i, weight + i, flat ? twist + 3 * i : nullptr,
                           rotation + 4 * i, axes, h);
    }
    if (i == count) return;
    HWY_ALIGN float some[16 * most] = {};
    HWY_ALIGN float w[most] = {};
    HWY_ALIGN float shape[3 * most] = {};
    HWY_ALIGN float q[4 * most] = {};
    const std::size_t rest = count - i;
    std::copy_n(slots + 16 * i, 16 * rest, some);
    std::copy_n(weight + i, rest, w);
    if (flat) std::copy_n(twist + 3 * i, 3 * rest, shape);
    std::copy_n(rotation + 4 * i, 4 * rest, q);
    match_groups<flat>(d, some, w, shape, q, axes, h);
    std::copy_n(some, 16 * rest, slots + 16 * i);
    std::copy_n(q, 4 * rest, rotation + 4 * i);
}

}  // namespace match_kernel

void match_slots_of(std::size_t count, float* slots, const float* weight, const float* twist,
                    float* rotation, const std::array<int, 3>& axes, float h)
{
    if (twist) {
        match_kernel::match_all<true>(count, slots, weight, twist, rotation, axes, h);
    } else {
        match_kernel::match_all<false>(count, slots, weight, twist, rotation, axes, h);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(match_slots_of);

void match_slots(std::size_t count, float* slots, const float* weight, const float* twist,
                 float* rotation, const std::array<int, 3>& axes, float h)
{
    HWY_DYNAMIC_DISPATCH(match_slots_of)(count, slots, weight, twist, rotation, axes, h);
}

}  // namespace physics
#endif
