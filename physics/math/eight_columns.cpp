#include "physics/math/eight_columns.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/math/eight_columns.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, 8>;
using Vec = hn::Vec<Lanes>;
constexpr std::size_t lanes = hn::MaxLanes(Lanes()), parts = 8 / lanes;

// out += A^T B over some rows.
void add_transposed_times(std::size_t rows, const double* a, const double* b, double* out)
{
    const Lanes d;
    for (std::size_t part = 0; part < parts; ++part) {
        double* to = out + part * lanes;
        Vec s0 = hn::LoadU(d, to), s1 = hn::LoadU(d, to + 8), s2 = hn::LoadU(d, to + 16);
        Vec s3 = hn::LoadU(d, to + 24), s4 = hn::LoadU(d, to + 32), s5 = hn::LoadU(d, to + 40);
        Vec s6 = hn::LoadU(d, to + 48), s7 = hn::LoadU(d, to + 56);
        for (std::size_t r = 0; r < rows; ++r) {
            const double* ar = a + 8 * r;
            const Vec br = hn::LoadU(d, b + 8 * r + part * lanes);
            s0 = hn::Add(s0, hn::Mul(hn::Set(d, ar[0]), br));
            s1 = hn::Add(s1, hn::Mul(hn::Set(d, ar[1]), br));
            s2 = hn::Add(s2, hn::Mul(hn::Set(d, ar[2]), br));
            s3 = hn::Add(s3, hn::Mul(hn::Set(d, ar[3]), br));
            s4 = hn::Add(s4, hn::Mul(hn::Set(d, ar[4]), br));
            s5 = hn::Add(s5, hn::Mul(hn::Set(d, ar[5]), br));
            s6 = hn::Add(s6, hn::Mul(hn::Set(d, ar[6]), br));
            s7 = hn::Add(s7, hn::Mul(hn::Set(d, ar[7]), br));
        }
        hn::StoreU(s0, d, to), hn::StoreU(s1, d, to + 8), hn::StoreU(s2, d, to + 16);
        hn::StoreU(s3, d, to + 24), hn::StoreU(s4, d, to + 32), hn::StoreU(s5, d, to + 40);
        hn::StoreU(s6, d, to + 48), hn::StoreU(s7, d, to + 56);
    }
}

// C -= A b over some rows.
void subtract_rows(std::size_t rows, const double* a, const double* b, double* c)
{
    const Lanes d;
    for (std::size_t part = 0; part < parts; ++part) {
        const double* from = b + part * lanes;
        const Vec b0 = hn::LoadU(d, from), b1 = hn::LoadU(d, from + 8);
        const Vec b2 = hn::LoadU(d, from + 16), b3 = hn::LoadU(d, from + 24);
        const Vec b4 = hn::LoadU(d, from + 32), b5 = hn::LoadU(d, from + 40);
        const Vec b6 = hn::LoadU(d, from + 48), b7 = hn::LoadU(d, from + 56);
        for (std::size_t r = 0; r < rows; ++r) {
            const double* ar = a + 8 * r;
            double* to = c + 8 * r + part * lanes;
            const Vec low =
                hn::Add(hn::Add(hn::Mul(hn::Set(d, ar[0]), b0), hn::Mul(hn::Set(d, ar[1]), b1)),
                        hn::Add(hn::Mul(hn::Set(d, ar[2]), b2), hn::Mul(hn::Set(d, ar[3]), b3)));
            const Vec high =
                hn::Add(hn::Add(hn::Mul(hn::Set(d, ar[4]), b4), hn::Mul(hn::Set(d, ar[5]), b5)),
                        hn::Add(hn::Mul(hn::Set(d, ar[6]), b6), hn::Mul(hn::Set(d, ar[7]), b7)));
            hn::StoreU(hn::Sub(hn::LoadU(d, to), hn::Add(low, high)), d, to);
        }
    }
}

void rows_in_threes(std::size_t begin, std::size_t end, const SparseRows& a, const double* x,
                    double* to)
{
    const Lanes d;
    for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t part = 0; part < parts; ++part) {
            Vec s0 = hn::Zero(d), s1 = s0, s2 = s0;
            for (int e = a.first[i]; e < a.first[i + 1]; ++e) {
                const Vec m = hn::Set(d, a.number[e]);
                const double* from = x + 24 * std::size_t(a.column[e]) + part * lanes;
                s0 = hn::Add(s0, hn::Mul(m, hn::LoadU(d, from)));
                s1 = hn::Add(s1, hn::Mul(m, hn::LoadU(d, from + 8)));
                s2 = hn::Add(s2, hn::Mul(m, hn::LoadU(d, from + 16)));
            }
            double* at = to + 24 * i + part * lanes;
            hn::StoreU(s0, d, at), hn::StoreU(s1, d, at + 8), hn::StoreU(s2, d, at + 16);
        }
    }
}

constexpr std::size_t group = 4;  // columns of a factor at a time

// A row of W numbers, in as few vectors as the processor can.
template <std::size_t W> using Row = hn::CappedTag<double, W>;

// Columns n (up to four) of the factor from `l` on, which has `below` rows more; x from the first
// of them on. Missing columns are counted as zeros.
template <std::size_t W>
void group_down(std::size_t n, std::size_t below, const double* l, std::size_t step, double* x)
{
    const Row<W> d;
    using V = hn::Vec<Row<W>>;
    for (std::size_t at = 0; at < W; at += hn::MaxLanes(d)) {
        double* own = x + at;
        V y[group] = {hn::Zero(d), hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (std::size_t j = 0; j < n; ++j) {
            y[j] = hn::LoadU(d, own + W * j);
            for (std::size_t k = 0; k < j; ++k) {
                y[j] = hn::Sub(y[j], hn::Mul(hn::Set(d, l[step * k + j]), y[k]));
            }
            y[j] = hn::Div(y[j], hn::Set(d, l[step * j + j]));
            hn::StoreU(y[j], d, own + W * j);
        }
        const double* l0 = l + n;
        const double* l1 = n > 1 ? l0 + step : l0;
        const double* l2 = n > 2 ? l0 + 2 * step : l0;
        const double* l3 = n > 3 ? l0 + 3 * step : l0;
        const V y0 = y[0], y1 = y[1], y2 = y[2], y3 = y[3];
        for (std::size_t i = 0; i < below; ++i) {
            double* to = own + W * (n + i);
            const V low = hn::Add(hn::Mul(hn::Set(d, l0[i]), y0), hn::Mul(hn::Set(d, l1[i]), y1));
            const V high = hn::Add(hn::Mul(hn::Set(d, l2[i]), y2), hn::Mul(hn::Set(d, l3[i]), y3));
            hn::StoreU(hn::Sub(hn::LoadU(d, to), hn::Add(low, high)), d, to);
        }
    }
}

template <std::size_t W>
void group_up(std::size_t n, std::size_t below, const double* l, std::size_t step, double* x)
{
    const Row<W> d;
    using V = hn::Vec<Row<W>>;
    for (std::size_t at = 0; at < W; at += hn::MaxLanes(d)) {
        double* own = x + at;
        const double* l0 = l + n;
        const double* l1 = n > 1 ? l0 + step : l0;
        const double* l2 = n > 2 ? l0 + 2 * step : l0;
        const double* l3 = n > 3 ? l0 + 3 * step : l0;
        V s0 = hn::Zero(d), s1 = s0, s2 = s0, s3 = s0;
        for (std::size_t i = 0; i < below; ++i) {
            const V xi = hn::LoadU(d, own + W * (n + i));
            s0 = hn::Add(s0, hn::Mul(hn::Set(d, l0[i]), xi));
            s1 = hn::Add(s1, hn::Mul(hn::Set(d, l1[i]), xi));
            s2 = hn::Add(s2, hn::Mul(hn::Set(d, l2[i]), xi));
            s3 = hn::Add(s3, hn::Mul(hn::Set(d, l3[i]), xi));
        }
        const V sums[group] = {s0, s1, s2, s3};
        V y[group] = {s0, s1, s2, s3};
        for (std::size_t j = n; j-- > 0;) {
            y[j] = hn::Sub(hn::LoadU(d, own + W * j), sums[j]);
            for (std::size_t k = j + 1; k < n; ++k) {
                y[j] = hn::Sub(y[j], hn::Mul(hn::Set(d, l[step * j + k]), y[k]));
            }
            y[j] = hn::Div(y[j], hn::Set(d, l[step * j + j]));
            hn::StoreU(y[j], d, own + W * j);
        }
    }
}

template <std::size_t W>
void down_any(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    const std::size_t all = pivots + border;
    for (std::size_t j = 0; j < pivots; j += group) {
        const std::size_t n = std::min(group, pivots - j);
        group_down<W>(n, all - j - n, columns + j * all + j, all, x + W * j);
    }
}

template <std::size_t W>
void up_any(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    const std::size_t all = pivots + border;
    for (std::size_t end = pivots; end > 0;) {
        const std::size_t j = (end - 1) / group * group, n = end - j;
        group_up<W>(n, all - end, columns + j * all + j, all, x + W * j);
        end = j;
    }
}

void down_eight(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    down_any<8>(pivots, border, columns, x);
}

void up_eight(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    up_any<8>(pivots, border, columns, x);
}

void down_four(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    down_any<4>(pivots, border, columns, x);
}

void up_four(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    up_any<4>(pivots, border, columns, x);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(add_transposed_times);
HWY_EXPORT(subtract_rows);
HWY_EXPORT(rows_in_threes);
HWY_EXPORT(down_eight);
HWY_EXPORT(up_eight);
HWY_EXPORT(down_four);
HWY_EXPORT(up_four);

namespace {

constexpr std::size_t run_rows = 2048;

struct Sum {
    Eights of = Eights::Zero();
    Sum operator+(const Sum& other) const { return {of + other.of}; }
};

}  // namespace

Eights transposed_times(const EightColumns& a, const EightColumns& b)
{
    return geometry::ordered_sum(a.size() / eight, run_rows, Sum{},
                                 [&](std::size_t begin, std::size_t end) {
                                     Sum sum;
                                     HWY_DYNAMIC_DISPATCH(add_transposed_times)
                                     (end - begin, &a[eight * begin], &b[eight * begin],
                                      sum.of.data());
                                     return sum;
                                 })
        .of;
}

void subtract_times(const EightColumns& a, const Eights& b, EightColumns& c)
{
    geometry::parallel_for(a.size() / eight, run_rows, [&](std::size_t begin, std::size_t end) {
        HWY_DYNAMIC_DISPATCH(subtract_rows)
        (end - begin, &a[eight * begin], b.data(), &c[eight * begin]);
    });
}

void times_in_threes(std::size_t n, const SparseRows& a, const EightColumns& x, EightColumns& to)
{
    to.resize(3 * eight * n);
    geometry::parallel_for(n, 256, [&](std::size_t begin, std::size_t end) {
        HWY_DYNAMIC_DISPATCH(rows_in_threes)(begin, end, a, x.data(), to.data());
    });
}

void solve_down(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    HWY_DYNAMIC_DISPATCH(down_eight)(pivots, border, columns, x);
}

void solve_up(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    HWY_DYNAMIC_DISPATCH(up_eight)(pivots, border, columns, x);
}

void solve_four_down(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    HWY_DYNAMIC_DISPATCH(down_four)(pivots, border, columns, x);
}

void solve_four_up(std::size_t pivots, std::size_t border, const double* columns, double* x)
{
    HWY_DYNAMIC_DISPATCH(up_four)(pivots, border, columns, x);
}

}  // namespace physics
#endif
