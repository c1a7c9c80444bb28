#include "physics/lattice/pair_pushes.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/lattice/pair_pushes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace pairs_kernel {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, PairsAbreast::most>;
using V = hn::Vec<D>;

// Velocities of a vectorful of particles, less those of as many others; and impulses of those,
// times their inverse masses, added to the ones and taken from the others.
#if HWY_TARGET != HWY_SCALAR && HWY_MAX_BYTES >= 32

// Three numbers of four are in use.
inline constexpr hn::CappedTag<double, 4> wide{};
inline constexpr hn::Half<D> four{};
static_assert(hn::MaxLanes(D()) == 8);

HWY_INLINE void load(const PairsAbreast& row, std::size_t, const double* v, V (&out)[3])
{
    const D d;
    const auto three = hn::FirstN(wide, 3);
    hn::Vec<decltype(four)> each[8];
    for (std::size_t l = 0; l < 8; ++l) {
        each[l] = hn::DemoteTo(four, hn::Sub(hn::MaskedLoad(three, wide, v + 3 * row.a[l]),
                                             hn::MaskedLoad(three, wide, v + 3 * row.b[l])));
    }
    V both[4];
    for (std::size_t l = 0; l < 4; ++l) both[l] = hn::Combine(d, each[l + 4], each[l]);
    const V xy_even = hn::InterleaveLower(d, both[0], both[2]);
    const V xy_odd = hn::InterleaveLower(d, both[1], both[3]);
    out[0] = hn::InterleaveLower(d, xy_even, xy_odd);
    out[1] = hn::InterleaveUpper(d, xy_even, xy_odd);
    out[2] = hn::InterleaveLower(d, hn::InterleaveUpper(d, both[0], both[2]),
                                 hn::InterleaveUpper(d, both[1], both[3]));
}

HWY_INLINE void add(const V (&impulse)[3], const PairsAbreast& row, std::size_t,
                    const double* inverse_mass, double* v)
{
    const D d;
    const auto three = hn::FirstN(wide, 3);
    const V zero = hn::Zero(d);
    const V xz = hn::InterleaveLower(d, impulse[0], impulse[2]);
    const V xz_on = hn::InterleaveUpper(d, impulse[0], impulse[2]);
    const V y = hn::InterleaveLower(d, impulse[1], zero);
    const V y_on = hn::InterleaveUpper(d, impulse[1], zero);
    const V both[4] = {hn::InterleaveLower(d, xz, y), hn::InterleaveUpper(d, xz, y),
                       hn::InterleaveLower(d, xz_on, y_on), hn::InterleaveUpper(d, xz_on, y_on)};
    const auto store = [&](hn::Vec<decltype(wide)> sum, double* to) HWY_ATTR {
        const hn::Half<decltype(wide)> two;
        hn::StoreU(hn::LowerHalf(two, sum), two, to);
        to[2] = hn::GetLane(hn::UpperHalf(two, sum));
    };
    for (std::size_t l = 0; l < row.count; ++l) {
        const auto half = l < 4 ? hn::LowerHalf(four, both[l]) : hn::UpperHalf(four, both[l - 4]);
        const auto change = hn::PromoteTo(wide, half);
        const std::uint32_t a = row.a[l], b = row.b[l];
        store(hn::Add(hn::MaskedLoad(three, wide, v + 3 * a),
                      hn::Mul(hn::Set(wide, inverse_mass[a]), change)),
              v + 3 * a);
        store(hn::Sub(hn::MaskedLoad(three, wide, v + 3 * b),
                      hn::Mul(hn::Set(wide, inverse_mass[b]), change)),
              v + 3 * b);
    }
}

#else

HWY_INLINE void load(const PairsAbreast& row, std::size_t from, const double* v, V (&out)[3])
{
    constexpr std::size_t lanes = hn::MaxLanes(D());
    for (std::size_t c = 0; c < 3; ++c) {
        HWY_ALIGN float some[lanes];
        for (std::size_t l = 0; l < lanes; ++l) {
            some[l] = float(v[3 * row.a[from + l] + c] - v[3 * row.b[from + l] + c]);
        }
        out[c] = hn::Load(D(), some);
    }
}

HWY_INLINE void add(const V (&impulse)[3], const PairsAbreast& row, std::size_t from,
                    const double* inverse_mass, double* v)
{
    constexpr std::size_t lanes = hn::MaxLanes(D());
    for (std::size_t c = 0; c < 3; ++c) {
        HWY_ALIGN float some[lanes];
        hn::Store(impulse[c], D(), some);
        for (std::size_t l = 0; l < lanes && from + l < row.count; ++l) {
            const std::uint32_t a = row.a[from + l], b = row.b[from + l];
            v[3 * a + c] += inverse_mass[a] * double(some[l]);
            v[3 * b + c] -= inverse_mass[b] * double(some[l]);
        }
    }
}

#endif

HWY_INLINE V dot(const V (&a)[3], const V (&b)[3])
{
    return hn::Add(hn::Add(hn::Mul(a[0], b[0]), hn::Mul(a[1], b[1])), hn::Mul(a[2], b[2]));
}

// As change_of() in lattice_contact.cpp.
HWY_INLINE void solve_some(PairsAbreast& row, std::size_t from, float friction,
                           const double* inverse_mass, double* v)
{
    const D d;
    const V zero = hn::Zero(d);
    V normal[3], drag[3], speed[3], change[3];
    for (std::size_t c = 0; c < 3; ++c) {
        normal[c] = hn::LoadU(d, row.normal[c] + from);
        drag[c] = hn::LoadU(d, row.drag[c] + from);
    }
    load(row, from, v, speed);
    const V mass = hn::LoadU(d, row.mass + from), before = hn::LoadU(d, row.impulse + from);
    const V along = dot(speed, normal);
    const V wanted = hn::Mul(hn::Add(along, hn::LoadU(d, row.bias + from)), mass);
    const V impulse = hn::Max(zero, hn::Sub(before, wanted));
    if (hn::AllFalse(d, hn::Gt(hn::Max(impulse, before), zero))) return;  // they do not touch

    V across[3];
    for (std::size_t c = 0; c < 3; ++c) {
        const V slip = hn::Sub(speed[c], hn::Mul(along, normal[c]));
        across[c] = hn::Sub(drag[c], hn::Mul(mass, slip));
    }
    const V most = hn::Mul(hn::Set(d, friction), impulse);
    const V size = hn::Sqrt(dot(across, across));
    const V tiny = hn::Set(d, std::numeric_limits<float>::min());
    const V share = hn::Div(most, hn::Max(hn::Max(most, size), tiny));
    const V more = hn::Sub(impulse, before);
    for (std::size_t c = 0; c < 3; ++c) {
        across[c] = hn::Mul(across[c], share);
        change[c] = hn::Add(hn::Mul(more, normal[c]), hn::Sub(across[c], drag[c]));
        hn::StoreU(across[c], d, row.drag[c] + from);
    }
    hn::StoreU(impulse, d, row.impulse + from);
    add(change, row, from, inverse_mass, v);
}

}  // namespace pairs_kernel

void solve_all(PairsAbreast* rows, std::size_t count, float friction, const double* inverse_mass,
               double* v)
{
    constexpr std::size_t lanes = hwy::HWY_NAMESPACE::MaxLanes(pairs_kernel::D());
    for (std::size_t k = 0; k < count; ++k) {
        for (std::size_t from = 0; from < rows[k].count; from += lanes) {
            pairs_kernel::solve_some(rows[k], from, friction, inverse_mass, v);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(solve_all);

void solve_rows(std::span<PairsAbreast> rows, float friction,
                const std::vector<double>& inverse_mass, std::vector<Vec3>& v)
{
    HWY_DYNAMIC_DISPATCH(solve_all)
    (rows.data(), rows.size(), friction, inverse_mass.data(), v.data()->data());
}

}  // namespace physics
#endif
