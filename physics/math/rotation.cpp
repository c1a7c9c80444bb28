#include "physics/math/rotation.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/math/rotation.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "physics/math/rotation-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {

// Calls group(pointer to matrices, their stride, pointer to rotations, their stride) for each few
// vectorfuls; the last, incomplete ones are worked on in a copy padded with zeros.
template <class T, int inputs, int outputs, std::size_t vectors, class Group>
void for_each_group(std::size_t n, const T* a, std::size_t a_stride, T* q, std::size_t q_stride,
                    const Group& group)
{
    const hn::ScalableTag<T> d;
    const std::size_t length = vectors * hn::Lanes(d);
    std::size_t i = 0;
    for (; i + length <= n; i += length) group(a + i, a_stride, q + i, q_stride);
    if (i == n) return;
    HWY_ALIGN T a_rest[inputs * vectors * hn::MaxLanes(d)] = {};
    HWY_ALIGN T q_rest[outputs * vectors * hn::MaxLanes(d)] = {};
    const std::size_t rest = n - i;
    for (std::size_t k = 0; k < inputs; ++k) {
        for (std::size_t j = 0; j < rest; ++j) a_rest[k * length + j] = a[k * a_stride + i + j];
    }
    for (std::size_t k = 0; k < outputs; ++k) {
        for (std::size_t j = 0; j < rest; ++j) q_rest[k * length + j] = q[k * q_stride + i + j];
    }
    group(a_rest, length, q_rest, length);
    for (std::size_t k = 0; k < outputs; ++k) {
        for (std::size_t j = 0; j < rest; ++j) q[k * q_stride + i + j] = q_rest[k * length + j];
    }
}

template <class T>
void extract(std::size_t n, const T* a, std::size_t a_stride, T* q, std::size_t q_stride)
{
    constexpr std::size_t at_once = 2;
    const hn::ScalableTag<T> d;
    for_each_group<T, 9, 4, at_once>(
        n, a, a_stride, q, q_stride,
        [d](const T* from, std::size_t from_stride, T* to, std::size_t to_stride) HWY_ATTR {
            const std::size_t lanes = hn::Lanes(d);
            hn::Vec<decltype(d)> matrix[at_once][9], rotation[at_once][4];
            for (std::size_t g = 0; g < at_once; ++g) {
                for (std::size_t k = 0; k < 9; ++k) {
                    matrix[g][k] = hn::LoadU(d, from + k * from_stride + g * lanes);
                }
                for (std::size_t k = 0; k < 4; ++k) {
                    rotation[g][k] = hn::LoadU(d, to + k * to_stride + g * lanes);
                }
            }
            extract_rotations(d, matrix, rotation);
            for (std::size_t g = 0; g < at_once; ++g) {
                for (std::size_t k = 0; k < 4; ++k) {
                    hn::StoreU(rotation[g][k], d, to + k * to_stride + g * lanes);
                }
            }
        });
}

template <class T>
void extract_2d(std::size_t n, const T* a, std::size_t a_stride, T* cs, std::size_t cs_stride)
{
    const hn::ScalableTag<T> d;
    for_each_group<T, 4, 2, 1>(
        n, a, a_stride, cs, cs_stride,
        [d](const T* from, std::size_t from_stride, T* to, std::size_t to_stride) HWY_ATTR {
            hn::Vec<decltype(d)> matrix[4];
            for (std::size_t k = 0; k < 4; ++k) matrix[k] = hn::LoadU(d, from + k * from_stride);
            auto cosine = hn::LoadU(d, to), sine = hn::LoadU(d, to + to_stride);
            extract_rotation_2d(d, matrix, cosine, sine);
            hn::StoreU(cosine, d, to);
            hn::StoreU(sine, d, to + to_stride);
        });
}

// Dispatch tables take plain functions.
void extract_float(std::size_t n, const float* a, std::size_t as, float* q, std::size_t qs)
{
    extract(n, a, as, q, qs);
}
void extract_double(std::size_t n, const double* a, std::size_t as, double* q, std::size_t qs)
{
    extract(n, a, as, q, qs);
}
void extract_2d_float(std::size_t n, const float* a, std::size_t as, float* cs, std::size_t css)
{
    extract_2d(n, a, as, cs, css);
}
void extract_2d_double(std::size_t n, const double* a, std::size_t as, double* cs, std::size_t css)
{
    extract_2d(n, a, as, cs, css);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(extract_float);
HWY_EXPORT(extract_double);
HWY_EXPORT(extract_2d_float);
HWY_EXPORT(extract_2d_double);

void extract_rotations(std::size_t n, const float* a, std::size_t a_stride, float* q,
                       std::size_t q_stride)
{
    HWY_DYNAMIC_DISPATCH(extract_float)(n, a, a_stride, q, q_stride);
}

void extract_rotations(std::size_t n, const double* a, std::size_t a_stride, double* q,
                       std::size_t q_stride)
{
    HWY_DYNAMIC_DISPATCH(extract_double)(n, a, a_stride, q, q_stride);
}

void extract_rotations_2d(std::size_t n, const float* a, std::size_t a_stride, float* cs,
                          std::size_t cs_stride)
{
    HWY_DYNAMIC_DISPATCH(extract_2d_float)(n, a, a_stride, cs, cs_stride);
}

void extract_rotations_2d(std::size_t n, const double* a, std::size_t a_stride, double* cs,
                          std::size_t cs_stride)
{
    HWY_DYNAMIC_DISPATCH(extract_2d_double)(n, a, a_stride, cs, cs_stride);
}

Eigen::Quaterniond extract_rotation(const Mat3& a, const Eigen::Quaterniond& last)
{
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = a;
    double q[4] = {last.w(), last.x(), last.y(), last.z()};
    extract_rotations(1, rows.data(), 1, q, 1);
    return {q[0], q[1], q[2], q[3]};
}

}  // namespace physics
#endif
