#pragma once

// Loops over the numbers of a large body's vectors, on both cores.

#include "geometry/base/parallel.hpp"
#include "physics/math/aligned_memory.hpp"

#include <algorithm>

namespace physics {

// A quarter of a megabyte of each vector: fewer take less time than waking a thread does.
inline constexpr std::size_t numbers_a_piece = 32768;

// Calls f(i) for 0..n, which sets what no other i reads.
template <class F> void for_numbers(std::size_t n, const F& f)
{
    geometry::parallel_for(n, numbers_a_piece, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) f(i);
    });
}

// v has n numbers, all of them `value`.
template <class T> void fill_numbers(Aligned<T>& v, std::size_t n, T value)
{
    v.resize(n);
    for_numbers(n, [&v, value](std::size_t i) { v[i] = value; });
}

// to = from, both of n numbers.
template <class T, class U> void copy_numbers(std::size_t n, const U* from, T* to)
{
    for_numbers(n, [from, to](std::size_t i) { to[i] = static_cast<T>(from[i]); });
}
template <class T, class U> void copy_numbers(const Aligned<U>& from, Aligned<T>& to)
{
    to.resize(from.size());
    copy_numbers(from.size(), from.data(), to.data());
}

// The largest f(i) over 0..n above 0; 0 where there is none.
template <class F> double greatest_over(std::size_t n, const F& f)
{
    std::vector<double> most((n + numbers_a_piece - 1) / numbers_a_piece, 0);
    geometry::parallel_for(most.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const std::size_t last = std::min(n, (p + 1) * numbers_a_piece);
            for (std::size_t i = p * numbers_a_piece; i < last; ++i) {
                most[p] = std::max(most[p], f(i));
            }
        }
    });
    return most.empty() ? 0 : *std::max_element(most.begin(), most.end());
}

// The sum of f(i) over 0..n, the same bits for any number of threads.
template <class F> double sum_over(std::size_t n, const F& f)
{
    return geometry::ordered_sum(n, numbers_a_piece, 0.0, [&](std::size_t begin, std::size_t end) {
        double sum = 0;
        for (std::size_t i = begin; i < end; ++i) sum += f(i);
        return sum;
    });
}

inline double sum_of(const Aligned<double>& v)
{
    return sum_over(v.size(), [&](std::size_t i) { return v[i]; });
}

}  // namespace physics
