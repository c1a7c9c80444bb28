#pragma once

// The members of a plain struct as a tuple of references, found by the compiler, so that what walks
// over "every field" (sizes, serialisation) cannot forget a field that was added later.
// A struct qualifies when it is an aggregate without bases and without a bare array member
// (std::array as a direct member included; inside a vector it is fine).

#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

namespace graph {

namespace detail {

struct Anything {
    template <class T> operator T() const;  // declared only: used in unevaluated context
};

template <class T, std::size_t... I> constexpr bool takes(std::index_sequence<I...>)
{
    return requires
    {
        T{(static_cast<void>(I), Anything{})...};
    };
}

template <class T, std::size_t N = 24> constexpr std::size_t field_count()
{
    if constexpr (N == 0 || takes<T>(std::make_index_sequence<N>{})) {
        return N;
    } else {
        return field_count<T, N - 1>();
    }
}

}  // namespace detail

template <class T>
concept PlainStruct = std::is_aggregate_v<T> && std::is_class_v<T> && !std::is_empty_v<T>;

// References to every member of `s` in order of declaration.
template <class T> auto fields(T& s)
{
    constexpr std::size_t n = detail::field_count<std::remove_const_t<T>>();
    // clang-format off
#define ASPIC_TIE(count, ...) \
    if constexpr (n == count) { auto& [__VA_ARGS__] = s; return std::tie(__VA_ARGS__); } else
    ASPIC_TIE(1, a)
    ASPIC_TIE(2, a, b)
    ASPIC_TIE(3, a, b, c)
    ASPIC_TIE(4, a, b, c, d)
    ASPIC_TIE(5, a, b, c, d, e)
    ASPIC_TIE(6, a, b, c, d, e, f)
    ASPIC_TIE(7, a, b, c, d, e, f, g)
    ASPIC_TIE(8, a, b, c, d, e, f, g, h)
    ASPIC_TIE(9, a, b, c, d, e, f, g, h, i)
    ASPIC_TIE(10, a, b, c, d, e, f, g, h, i, j)
    ASPIC_TIE(11, a, b, c, d, e, f, g, h, i, j, k)
    ASPIC_TIE(12, a, b, c, d, e, f, g, h, i, j, k, l)
    ASPIC_TIE(13, a, b, c, d, e, f, g, h, i, j, k, l, m)
    ASPIC_TIE(14, a, b, c, d, e, f, g, h, i, j, k, l, m, o)
    ASPIC_TIE(15, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p)
    ASPIC_TIE(16, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q)
    ASPIC_TIE(17, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r)
    ASPIC_TIE(18, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r, t)
    ASPIC_TIE(19, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r, t, u)
    ASPIC_TIE(20, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r, t, u, v)
    ASPIC_TIE(21, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r, t, u, v, w)
    ASPIC_TIE(22, a, b, c, d, e, f, g, h, i, j, k, l, m, o, p, q, r, t, u, v, w, x)
    {
        static_assert(n <= 22 && n > 0, "split this struct: fields() binds up to 22 members");
    }
#undef ASPIC_TIE
    // clang-format on
}

}  // namespace graph
