#include "physics/math/corner_vectors.hpp"

#include "geometry/base/parallel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/math/corner_vectors.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The sum over i of term(d, i) in 16 lanes, for i = 0, 16, 32 .. n; lanes are added up in double.
template <class T, class Term> HWY_INLINE double lane_sum(std::size_t n, const Term& term)
{
    const hn::CappedTag<T, vector_lanes> d;
    constexpr std::size_t lanes = hn::MaxLanes(d);
    hn::Vec<decltype(d)> sum[vector_lanes / lanes];
    for (auto& s : sum) s = hn::Zero(d);
    for (std::size_t i = 0; i < n; i += vector_lanes) {
        for (std::size_t k = 0; k < vector_lanes / lanes; ++k) {
            sum[k] = hn::Add(sum[k], term(d, i + k * lanes));
        }
    }
    HWY_ALIGN T lane[vector_lanes];
    for (std::size_t k = 0; k < vector_lanes / lanes; ++k) hn::Store(sum[k], d, lane + k * lanes);
    double total = 0;
    for (const T value : lane) total += static_cast<double>(value);
    return total;
}

template <class T> double diagonal_any(std::size_t n, const T* diagonal, const T* p, T* y)
{
    return lane_sum<T>(n, [&](auto d, std::size_t i) HWY_ATTR {
        const auto at = hn::LoadU(d, p + i);
        const auto out = hn::Add(hn::LoadU(d, y + i), hn::Mul(hn::LoadU(d, diagonal + i), at));
        hn::StoreU(out, d, y + i);
        return hn::Mul(at, out);
    });
}

template <class T>
double descend_any(std::size_t n, T alpha, const T* p, const T* y, const T* inverse, T* x, T* r,
                   T* z)
{
    return lane_sum<T>(n, [&](auto d, std::size_t i) HWY_ATTR {
        const auto a = hn::Set(d, alpha);
        hn::StoreU(hn::Add(hn::LoadU(d, x + i), hn::Mul(a, hn::LoadU(d, p + i))), d, x + i);
        const auto rest = hn::Sub(hn::LoadU(d, r + i), hn::Mul(a, hn::LoadU(d, y + i)));
        hn::StoreU(rest, d, r + i);
        const auto scaled = hn::Mul(hn::LoadU(d, inverse + i), rest);
        hn::StoreU(scaled, d, z + i);
        return hn::Mul(rest, scaled);
    });
}

template <class T> void turn_any(std::size_t n, T beta, const T* z, T* p)
{
    const hn::CappedTag<T, vector_lanes> d;
    for (std::size_t i = 0; i < n; i += hn::Lanes(d)) {
        const auto kept = hn::Mul(hn::Set(d, beta), hn::LoadU(d, p + i));
        hn::StoreU(hn::Add(hn::LoadU(d, z + i), kept), d, p + i);
    }
}

template <class T> double dot_any(std::size_t n, const T* r, const T* z)
{
    return lane_sum<T>(n, [&](auto d, std::size_t i) HWY_ATTR {
        return hn::Mul(hn::LoadU(d, r + i), hn::LoadU(d, z + i));
    });
}

// Dispatch tables take plain functions.
double diagonal_low(std::size_t n, const float* d, const float* p, float* y)
{
    return diagonal_any(n, d, p, y);
}
double diagonal_high(std::size_t n, const double* d, const double* p, double* y)
{
    return diagonal_any(n, d, p, y);
}
double descend_low(std::size_t n, float alpha, const float* p, const float* y, const float* inverse,
                   float* x, float* r, float* z)
{
    return descend_any(n, alpha, p, y, inverse, x, r, z);
}
double descend_high(std::size_t n, double alpha, const double* p, const double* y,
                    const double* inverse, double* x, double* r, double* z)
{
    return descend_any(n, alpha, p, y, inverse, x, r, z);
}
double dot_low(std::size_t n, const float* r, const float* z)
{
    return dot_any(n, r, z);
}
double dot_high(std::size_t n, const double* r, const double* z)
{
    return dot_any(n, r, z);
}
void turn_low(std::size_t n, float beta, const float* z, float* p)
{
    turn_any(n, beta, z, p);
}
void turn_high(std::size_t n, double beta, const double* z, double* p)
{
    turn_any(n, beta, z, p);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(diagonal_low);
HWY_EXPORT(diagonal_high);
HWY_EXPORT(descend_low);
HWY_EXPORT(descend_high);
HWY_EXPORT(dot_low);
HWY_EXPORT(dot_high);
HWY_EXPORT(turn_low);
HWY_EXPORT(turn_high);

namespace {

// Short runs keep single-precision sums accurate; threads share them only where there are many.
constexpr std::size_t run = 4096;
constexpr std::size_t runs_worth_threads = 16;

template <class Term> double sum_of_runs(std::size_t n, const Term& term)
{
    if (n < run * runs_worth_threads) {
        double total = 0;
        for (std::size_t i = 0; i < n; i += run) total += term(i, std::min(run, n - i));
        return total;
    }
    return geometry::ordered_sum(
        n, run, 0.0, [&](std::size_t begin, std::size_t end) { return term(begin, end - begin); });
}

template <class Each> void in_runs(std::size_t n, const Each& each)
{
    const std::size_t units = n / vector_lanes, grain = run * runs_worth_threads / vector_lanes;
    geometry::parallel_for(units, grain, [&](std::size_t begin, std::size_t end) {
        each(begin * vector_lanes, (end - begin) * vector_lanes);
    });
}

}  // namespace

double add_diagonal_times(std::size_t n, const float* d, const float* p, float* y)
{
    return sum_of_runs(n, [&](std::size_t i, std::size_t count) {
        return HWY_DYNAMIC_DISPATCH(diagonal_low)(count, d + i, p + i, y + i);
    });
}
double add_diagonal_times(std::size_t n, const double* d, const double* p, double* y)
{
    return sum_of_runs(n, [&](std::size_t i, std::size_t count) {
        return HWY_DYNAMIC_DISPATCH(diagonal_high)(count, d + i, p + i, y + i);
    });
}

double descend(std::size_t n, float alpha, const float* p, const float* y, const float* inverse,
               float* x, float* r, float* z)
{
    return sum_of_runs(n, [&](std::size_t i, std::size_t count) {
        return HWY_DYNAMIC_DISPATCH(descend_low)(count, alpha, p + i, y + i, inverse + i, x + i,
                                                 r + i, z + i);
    });
}
double descend(std::size_t n, double alpha, const double* p, const double* y, const double* inverse,
               double* x, double* r, double* z)
{
    return sum_of_runs(n, [&](std::size_t i, std::size_t count) {
        return HWY_DYNAMIC_DISPATCH(descend_high)(count, alpha, p + i, y + i, inverse + i, x + i,
                                                  r + i, z + i);
    });
}

double dot(std::size_t n, const float* r, const float* z)
{
    return sum_of_runs(n, [&](std::size_t i, std::size_t count) {
        return HWY_DYNAMIC_DISPATCH(dot_low)(count, r + i, z + i);
    });
}
double dot(std::size_t n, const double* r, const double* z)
{
    return sum_of_runs(n, [&](std::size_t i, std::size_t count) {
        return HWY_DYNAMIC_DISPATCH(dot_high)(count, r + i, z + i);
    });
}

void turn_direction(std::size_t n, float beta, const float* z, float* p)
{
    in_runs(n, [&](std::size_t i, std::size_t count) {
        HWY_DYNAMIC_DISPATCH(turn_low)(count, beta, z + i, p + i);
    });
}
void turn_direction(std::size_t n, double beta, const double* z, double* p)
{
    in_runs(n, [&](std::size_t i, std::size_t count) {
        HWY_DYNAMIC_DISPATCH(turn_high)(count, beta, z + i, p + i);
    });
}

}  // namespace physics
#endif
