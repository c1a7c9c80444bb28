#include "physics/math/dense_front.hpp"

#include "geometry/base/parallel.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/math/dense_front.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef PHYSICS_MATH_DENSE_FRONT_BLOCKS
#define PHYSICS_MATH_DENSE_FRONT_BLOCKS
namespace physics {

// A matrix by columns, each `step` after the one before.
template <class T> struct ByColumns {
    T* at = nullptr;
    std::size_t step = 0;
    T* of(std::size_t row, std::size_t column) const { return at + column * step + row; }
};

constexpr std::size_t tile_columns = 6;
constexpr std::size_t depth = 128;         // of one round of sums
constexpr std::size_t packed_rows = 192;   // a multiple of every tile's rows
constexpr std::size_t task_columns = 96;   // a multiple of tile_columns
constexpr std::size_t block_columns = 48;  // factored at a time

}  // namespace physics
#endif

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Lanes>;

// Rows (or columns) `from`, n of them, of a matrix in strips of `wide`: in each strip number k of
// all its rows, then number k + 1. The last strip is filled up with zeros.
void pack(ByColumns<const double> from, std::size_t n, std::size_t k, std::size_t wide, double* to)
{
    for (std::size_t i = 0; i < n; i += wide) {
        const std::size_t rows = std::min(wide, n - i);
        for (std::size_t j = 0; j < k; ++j, to += wide) {
            const double* column = from.of(i, j);
            for (std::size_t ii = 0; ii < rows; ++ii) to[ii] = column[ii];
            for (std::size_t ii = rows; ii < wide; ++ii) to[ii] = 0;
        }
    }
}

// sum[j] of one tile: two vectors of rows of a times each of six columns of b, summed over k.
void multiply_tile(std::size_t k, const double* a, const double* b, double* out)
{
    const Lanes d;
    const std::size_t lanes = hn::Lanes(d);
    Vec s00 = hn::Zero(d), s01 = s00, s02 = s00, s03 = s00, s04 = s00, s05 = s00;
    Vec s10 = s00, s11 = s00, s12 = s00, s13 = s00, s14 = s00, s15 = s00;
    for (std::size_t i = 0; i < k; ++i, a += 2 * lanes, b += tile_columns) {
        const Vec a0 = hn::LoadU(d, a), a1 = hn::LoadU(d, a + lanes);
        Vec bj = hn::Set(d, b[0]);
        s00 = hn::Add(s00, hn::Mul(a0, bj)), s10 = hn::Add(s10, hn::Mul(a1, bj));
        bj = hn::Set(d, b[1]);
        s01 = hn::Add(s01, hn::Mul(a0, bj)), s11 = hn::Add(s11, hn::Mul(a1, bj));
        bj = hn::Set(d, b[2]);
        s02 = hn::Add(s02, hn::Mul(a0, bj)), s12 = hn::Add(s12, hn::Mul(a1, bj));
        bj = hn::Set(d, b[3]);
        s03 = hn::Add(s03, hn::Mul(a0, bj)), s13 = hn::Add(s13, hn::Mul(a1, bj));
        bj = hn::Set(d, b[4]);
        s04 = hn::Add(s04, hn::Mul(a0, bj)), s14 = hn::Add(s14, hn::Mul(a1, bj));
        bj = hn::Set(d, b[5]);
        s05 = hn::Add(s05, hn::Mul(a0, bj)), s15 = hn::Add(s15, hn::Mul(a1, bj));
    }
    const auto put = [&](std::size_t j, Vec low, Vec high) {
        hn::StoreU(low, d, out + 2 * lanes * j);
        hn::StoreU(high, d, out + 2 * lanes * j + lanes);
    };
    put(0, s00, s10), put(1, s01, s11), put(2, s02, s12);
    put(3, s03, s13), put(4, s04, s14), put(5, s05, s15);
}

// C -= A B^T for C with m rows and n columns, A and B with k. Only rows from the diagonal on, which
// starts at C's first number.
void subtract_products(std::size_t m, std::size_t n, std::size_t k, ByColumns<const double> a,
                       ByColumns<const double> b, ByColumns<double> c)
{
    const Lanes d;
    const std::size_t tile_rows = 2 * hn::Lanes(d);
    thread_local std::vector<double> packed_a(packed_rows * depth), packed_b(task_columns * depth);
    double sum[16 * tile_columns];
    for (std::size_t k0 = 0; k0 < k; k0 += depth) {
        const std::size_t kn = std::min(depth, k - k0);
        pack({b.of(0, k0), b.step}, n, kn, tile_columns, packed_b.data());
        for (std::size_t i0 = 0; i0 < m; i0 += packed_rows) {
            const std::size_t in = std::min(packed_rows, m - i0);
            pack({a.of(i0, k0), a.step}, in, kn, tile_rows, packed_a.data());
            for (std::size_t j = 0; j < n && j < i0 + in; j += tile_columns) {
                const std::size_t jn = std::min(tile_columns, n - j);
                const std::size_t first = j > i0 ? (j - i0) / tile_rows * tile_rows : 0;
                for (std::size_t i = first; i < in; i += tile_rows) {
                    multiply_tile(kn, &packed_a[i * kn], &packed_b[j * kn], sum);
                    const std::size_t rows = std::min(tile_rows, in - i);
                    for (std::size_t jj = 0; jj < jn; ++jj) {
                        double* to = c.of(i0 + i, j + jj);
                        const double* s = sum + tile_rows * jj;
                        for (std::size_t ii = 0; ii < rows; ++ii) to[ii] -= s[ii];
                    }
                }
            }
        }
    }
}

// X L^T = A in place of A, m rows, for L with n columns.
void divide_by_transposed(std::size_t m, std::size_t n, ByColumns<const double> l,
                          ByColumns<double> x)
{
    const Lanes d;
    const std::size_t lanes = hn::Lanes(d), strip = 4 * lanes;
    std::size_t i = 0;
    for (; i + strip <= m; i += strip) {
        for (std::size_t j = 0; j < n; ++j) {
            double* own = x.of(i, j);
            Vec x0 = hn::LoadU(d, own), x1 = hn::LoadU(d, own + lanes);
            Vec x2 = hn::LoadU(d, own + 2 * lanes), x3 = hn::LoadU(d, own + 3 * lanes);
            for (std::size_t k = 0; k < j; ++k) {
                const Vec ljk = hn::Set(d, *l.of(j, k));
                const double* from = x.of(i, k);
                x0 = hn::Sub(x0, hn::Mul(hn::LoadU(d, from), ljk));
                x1 = hn::Sub(x1, hn::Mul(hn::LoadU(d, from + lanes), ljk));
                x2 = hn::Sub(x2, hn::Mul(hn::LoadU(d, from + 2 * lanes), ljk));
                x3 = hn::Sub(x3, hn::Mul(hn::LoadU(d, from + 3 * lanes), ljk));
            }
            const Vec ljj = hn::Set(d, *l.of(j, j));
            hn::StoreU(hn::Div(x0, ljj), d, own), hn::StoreU(hn::Div(x1, ljj), d, own + lanes);
            hn::StoreU(hn::Div(x2, ljj), d, own + 2 * lanes);
            hn::StoreU(hn::Div(x3, ljj), d, own + 3 * lanes);
        }
    }
    for (std::size_t j = 0; j < n && i < m; ++j) {
        for (std::size_t ii = i; ii < m; ++ii) {
            double own = *x.of(ii, j);
            for (std::size_t k = 0; k < j; ++k) own -= *x.of(ii, k) * *l.of(j, k);
            *x.of(ii, j) = own / *l.of(j, j);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(subtract_products);
HWY_EXPORT(divide_by_transposed);

namespace {

using Block = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;

constexpr std::size_t task_products = 500'000;  // below, a thread of its own is not worth it

// The lower part of C -= A B^T, m rows, n <= m columns, where B is the first n rows of A.
void subtract_square(std::size_t m, std::size_t n, std::size_t k, ByColumns<const double> a,
                     ByColumns<double> c)
{
    const std::size_t tasks = (n + task_columns - 1) / task_columns;
    const auto some = [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const std::size_t j = t * task_columns, columns = std::min(task_columns, n - j);
            const ByColumns<const double> from{a.of(j, 0), a.step};
            HWY_DYNAMIC_DISPATCH(subtract_products)
            (m - j, columns, k, from, from, {c.of(j, j), c.step});
        }
    };
    geometry::parallel_for(tasks, m * n * k < 2 * task_products ? tasks : 1, some);
}

// Factors the diagonal block of `n` columns and divides the `m` rows below it by it.
bool factor_block(std::size_t n, std::size_t m, ByColumns<double> from)
{
    Block block(from.at, Eigen::Index(n), Eigen::Index(n),
                Eigen::OuterStride<>(Eigen::Index(from.step)));
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factored(block);
    if (factored.info() != Eigen::Success) return false;
    const std::size_t rows = std::max<std::size_t>(64, task_products / (n * n) / 32 * 32);
    const std::size_t tasks = (m + rows - 1) / rows;
    geometry::parallel_for(tasks, 1, [&](std::size_t begin, std::size_t end) {
        const std::size_t first = begin * rows, last = std::min(m, end * rows);
        HWY_DYNAMIC_DISPATCH(divide_by_transposed)
        (last - first, n, {from.at, from.step}, {from.of(n + first, 0), from.step});
    });
    return true;
}

}  // namespace

bool eliminate_front(std::size_t pivots, std::size_t border, double* columns, double* rest)
{
    const std::size_t all = pivots + border;
    const ByColumns<double> a{columns, all};
    for (std::size_t j = 0; j < pivots; j += block_columns) {
        const std::size_t n = std::min(block_columns, pivots - j), next = j + n;
        if (!factor_block(n, all - next, {a.of(j, j), all})) return false;
        if (next == pivots) break;
        subtract_square(all - next, pivots - next, n, {a.of(next, j), all},
                        {a.of(next, next), all});
    }
    subtract_square(border, border, pivots, {a.of(pivots, 0), all}, {rest, border});
    return true;
}

}  // namespace physics
#endif
