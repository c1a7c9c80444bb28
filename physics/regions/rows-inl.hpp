// Quads of lines that are summed abreast, in SIMD vectors: a quad of one line, the same of the
// other, then the next quad of the first. With two quads a line:
//
//     [ first line, quad 0 | other line, quad 0 | first line, quad 1 | other line, quad 1 ]
//
// Included once for each Highway target.

#if defined(PHYSICS_ROWS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef PHYSICS_ROWS_INL_HPP
#undef PHYSICS_ROWS_INL_HPP
#else
#define PHYSICS_ROWS_INL_HPP
#endif

#include <hwy/highway.h>

#include <cstddef>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace sums_kernel {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR  // one line at a time
inline constexpr std::size_t abreast = 1;
#else
inline constexpr std::size_t abreast = 2;
#endif

// Eight numbers: a quad of one line and a quad of the other.
template <class D, class T>
HWY_INLINE hn::Vec<D> load_both(D d, const T* one, [[maybe_unused]] const T* other)
{
#if HWY_TARGET == HWY_SCALAR
    return hn::LoadU(d, one);
#else
    const hn::Half<D> half;
    return hn::Combine(d, hn::LoadU(half, other), hn::LoadU(half, one));
#endif
}
template <class D, class V, class T>
HWY_INLINE void store_one([[maybe_unused]] D d, V both, [[maybe_unused]] bool other, T* to)
{
#if HWY_TARGET == HWY_SCALAR
    hn::StoreU(both, d, to);
#else
    const hn::Half<D> half;
    hn::StoreU(other ? hn::UpperHalf(half, both) : hn::LowerHalf(half, both), half, to);
#endif
}

// Quads of all those lines in turn, that are added as one.
template <class T, std::size_t quads> struct Row {
    static constexpr std::size_t group = 4 * abreast, numbers = group * quads;
    using D = hn::CappedTag<T, group>;
    static constexpr std::size_t lanes = hn::MaxLanes(D()), parts = numbers / lanes;

    hn::Vec<D> part[parts];

    HWY_INLINE void clear()
    {
        for (auto& p : part) p = hn::Zero(D());
    }
    HWY_INLINE void load(const T* from)
    {
        for (std::size_t i = 0; i < parts; ++i) part[i] = hn::LoadU(D(), from + i * lanes);
    }
    HWY_INLINE void store(T* to) const
    {
        for (std::size_t i = 0; i < parts; ++i) hn::StoreU(part[i], D(), to + i * lanes);
    }
    // From the quads of each line, `at` the same place.
    HWY_INLINE void load(const T* const (&from)[abreast], std::ptrdiff_t at)
    {
        for (std::size_t i = 0; i < parts; ++i) {
            const std::size_t quad = i * lanes / group, within = i * lanes % group;
            if constexpr (lanes == 8) {
                part[i] = load_both(D(), from[0] + at + 4 * quad, from[1] + at + 4 * quad);
            } else {
                part[i] = hn::LoadU(D(), from[within / 4] + at + 4 * quad + within % 4);
            }
        }
    }
    HWY_INLINE void store_line(std::size_t line, T* to) const
    {
        for (std::size_t i = 0; i < parts; ++i) {
            const std::size_t quad = i * lanes / group, within = i * lanes % group;
            if constexpr (lanes == 8) {
                store_one(D(), part[i], line == 1, to + 4 * quad);
            } else if (within / 4 == line) {
                hn::StoreU(part[i], D(), to + 4 * quad + within % 4);
            }
        }
    }
    // `some` quads from `to` on, and of another row from `from` on.
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void copy(const Row<T, length>& o)
    {
        for (std::size_t i = 0; i < of(some); ++i) part[of(to) + i] = o.part[of(from) + i];
    }
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void add(const Row<T, length>& o)
    {
        for (std::size_t i = 0; i < of(some); ++i) {
            part[of(to) + i] = hn::Add(part[of(to) + i], o.part[of(from) + i]);
        }
    }
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void subtract(const Row<T, length>& o)
    {
        for (std::size_t i = 0; i < of(some); ++i) {
            part[of(to) + i] = hn::Sub(part[of(to) + i], o.part[of(from) + i]);
        }
    }
    template <std::size_t to, std::size_t from, std::size_t some, std::size_t length>
    HWY_INLINE void add_times(T factor, const Row<T, length>& o)
    {
        const auto times = hn::Set(D(), factor);
        for (std::size_t i = 0; i < of(some); ++i) {
            part[of(to) + i] = hn::Add(part[of(to) + i], hn::Mul(times, o.part[of(from) + i]));
        }
    }

private:
    static constexpr std::size_t of(std::size_t some) { return some * group / lanes; }
};

}  // namespace sums_kernel
}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#endif
