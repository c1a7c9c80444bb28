#include "physics/match_regions.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/match_regions.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/rotation-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace match_kernel {

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

// Quads of numbers, slot by slot, as vectors over slots: of[q][c] is number c of quad q.
HWY_INLINE void load_slots(D d, const float* from, V (&of)[4][4])
{
    const std::size_t lanes = hn::Lanes(d);
    HWY_ALIGN float number[4][4 * hn::MaxLanes(d)];
    for (std::size_t q = 0; q < 4; ++q) {
        V c[4];
        hn::LoadInterleaved4(d, from + 4 * q * lanes, c[0], c[1], c[2], c[3]);
        for (std::size_t k = 0; k < 4; ++k) hn::Store(c[k], d, number[k] + q * lanes);
    }
    for (std::size_t k = 0; k < 4; ++k) {
        hn::LoadInterleaved4(d, number[k], of[0][k], of[1][k], of[2][k], of[3][k]);
    }
}

HWY_INLINE void store_slots(D d, const V (&of)[4][4], float* to)
{
    const std::size_t lanes = hn::Lanes(d);
    HWY_ALIGN float number[4][4 * hn::MaxLanes(d)];
    for (std::size_t k = 0; k < 4; ++k) {
        hn::StoreInterleaved4(of[0][k], of[1][k], of[2][k], of[3][k], d, number[k]);
    }
    for (std::size_t q = 0; q < 4; ++q) {
        V c[4];
        for (std::size_t k = 0; k < 4; ++k) c[k] = hn::Load(d, number[k] + q * lanes);
        hn::StoreInterleaved4(c[0], c[1], c[2], c[3], d, to + 4 * q * lanes);
    }
}

// One vectorful of slots.
template <bool flat>
HWY_INLINE void match_group(D d, float* slots, const float* weight, const float* twist,
                            float* rotation, const std::array<int, 3>& axes, float h)
{
    constexpr std::size_t quads = flat ? 3 : 4;  // with the moments along axes
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    V s[4][4];
    load_slots(d, slots, s);
    const auto some = hn::Gt(s[0][3], zero);
    const V inverse = hn::IfThenElseZero(some, hn::Div(one, hn::IfThenElse(some, s[0][3], one)));

    // A_r, column by column.
    V column[3][3], centre[3], of_mass[3];
    for (std::size_t k = 0; k < 3; ++k) centre[k] = hn::Mul(inverse, s[0][k]);
    for (std::size_t m = 1; m < quads; ++m) {
        of_mass[m - 1] = hn::Mul(s[m][3], inverse);
        for (std::size_t k = 0; k < 3; ++k) {
            column[m - 1][k] = hn::Sub(s[m][k], hn::Mul(of_mass[m - 1], s[0][k]));
        }
    }
    V bent[3], shape[3], less = zero;
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
        // The normal, as long as the sides, stands in for the axis without extent.
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
    V a[9], q[4], r[9];
    for (std::size_t m = 0; m < 3; ++m) {
        for (std::size_t k = 0; k < 3; ++k) a[3 * k + std::size_t(axes[m])] = column[m][k];
    }
    hn::LoadInterleaved4(d, rotation, q[0], q[1], q[2], q[3]);
    extract_rotation(d, a, q);
    hn::StoreInterleaved4(q[0], q[1], q[2], q[3], d, rotation);
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
        s[m][3] = zero;
    }
    if constexpr (flat) {
        for (std::size_t k = 0; k < 3; ++k) {
            moved[k] = hn::Sub(moved[k], hn::Mul(less, bent[k]));
            s[3][k] = hn::Mul(w, bent[k]);
        }
        s[3][3] = zero;
    }
    for (std::size_t k = 0; k < 3; ++k) s[0][k] = hn::Mul(w, moved[k]);
    s[0][3] = zero;
    store_slots(d, s, slots);
}

template <bool flat>
void match_all(std::size_t count, float* slots, const float* weight, const float* twist,
               float* rotation, const std::array<int, 3>& axes, float h)
{
    const D d;
    const std::size_t lanes = hn::Lanes(d);
    std::size_t i = 0;
    for (; i + lanes <= count; i += lanes) {
        match_group<flat>(d, slots + 16 * i, weight + i, flat ? twist + 3 * i : nullptr,
                          rotation + 4 * i, axes, h);
    }
    if (i == count) return;
    HWY_ALIGN float some[16 * hn::MaxLanes(d)] = {};
    HWY_ALIGN float w[hn::MaxLanes(d)] = {};
    HWY_ALIGN float shape[3 * hn::MaxLanes(d)] = {};
    HWY_ALIGN float q[4 * hn::MaxLanes(d)] = {};
    const std::size_t rest = count - i;
    std::copy_n(slots + 16 * i, 16 * rest, some);
    std::copy_n(weight + i, rest, w);
    if (flat) std::copy_n(twist + 3 * i, 3 * rest, shape);
    std::copy_n(rotation + 4 * i, 4 * rest, q);
    match_group<flat>(d, some, w, shape, q, axes, h);
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
