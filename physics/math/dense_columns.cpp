#include "physics/math/dense_columns.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/math/dense_columns.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t unit = 16;  // lanes, whatever the processor

void add_all(std::size_t rows, std::size_t columns, const float* a, const float* x, float* y)
{
    const hn::CappedTag<float, unit> d;
    std::size_t j = 0;
    for (; j + 4 <= columns; j += 4) {
        const float* c = a + j * rows;
        const auto x0 = hn::Set(d, x[j]), x1 = hn::Set(d, x[j + 1]);
        const auto x2 = hn::Set(d, x[j + 2]), x3 = hn::Set(d, x[j + 3]);
        for (std::size_t i = 0; i < rows; i += hn::Lanes(d)) {
            const auto low =
                hn::Add(hn::Mul(hn::LoadU(d, c + i), x0), hn::Mul(hn::LoadU(d, c + rows + i), x1));
            const auto high = hn::Add(hn::Mul(hn::LoadU(d, c + 2 * rows + i), x2),
                                      hn::Mul(hn::LoadU(d, c + 3 * rows + i), x3));
            hn::StoreU(hn::Add(hn::LoadU(d, y + i), hn::Add(low, high)), d, y + i);
        }
    }
    for (; j < columns; ++j) {
        const float* c = a + j * rows;
        const auto xj = hn::Set(d, x[j]);
        for (std::size_t i = 0; i < rows; i += hn::Lanes(d)) {
            hn::StoreU(hn::Add(hn::LoadU(d, y + i), hn::Mul(hn::LoadU(d, c + i), xj)), d, y + i);
        }
    }
}

void dot_all(std::size_t rows, std::size_t columns, const float* a, const float* x, float* out)
{
    const hn::CappedTag<float, unit> d;
    constexpr std::size_t lanes = hn::MaxLanes(d), parts = unit / lanes;
    HWY_ALIGN float lane[unit];
    for (std::size_t j = 0; j < columns; ++j) {
        const float* c = a + j * rows;
        hn::Vec<decltype(d)> sum[parts];
        for (auto& s : sum) s = hn::Zero(d);
        for (std::size_t i = 0; i < rows; i += unit) {
            for (std::size_t k = 0; k < parts; ++k) {
                const std::size_t at = i + k * lanes;
                sum[k] = hn::Add(sum[k], hn::Mul(hn::LoadU(d, c + at), hn::LoadU(d, x + at)));
            }
        }
        for (std::size_t k = 0; k < parts; ++k) hn::Store(sum[k], d, lane + k * lanes);
        for (std::size_t width = unit / 2; width > 0; width /= 2) {
            for (std::size_t k = 0; k < width; ++k) lane[k] += lane[k + width];
        }
        out[j] = lane[0];
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(add_all);
HWY_EXPORT(dot_all);

void add_columns(std::size_t rows, std::size_t columns, const float* a, const float* x, float* y)
{
    HWY_DYNAMIC_DISPATCH(add_all)(rows, columns, a, x, y);
}

void column_dots(std::size_t rows, std::size_t columns, const float* a, const float* x, float* out)
{
    HWY_DYNAMIC_DISPATCH(dot_all)(rows, columns, a, x, out);
}

}  // namespace physics
#endif
