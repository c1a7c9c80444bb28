#include "physics/membrane.hpp"

#include "geometry/parallel.hpp"
#include "geometry/plane.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "physics/membrane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace physics {
namespace HWY_NAMESPACE {
namespace membrane_kernel {

namespace hn = hwy::HWY_NAMESPACE;

template <class V> struct Triple {
    V x, y, z;
};
template <class V> HWY_INLINE Triple<V> operator+(const Triple<V>& a, const Triple<V>& b)
{
    return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
template <class V> HWY_INLINE Triple<V> operator-(const Triple<V>& a, const Triple<V>& b)
{
    return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
template <class V> HWY_INLINE Triple<V> times(const V& s, const Triple<V>& a)
{
    return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)};
}
template <class V> HWY_INLINE V dot(const Triple<V>& a, const Triple<V>& b)
{
    return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
template <class V> HWY_INLINE Triple<V> cross(const Triple<V>& a, const Triple<V>& b)
{
    return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
            hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
            hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

// What a corner with the links e1 and e2 wants added to them, R - F, times `scale`.
template <class D, class V>
HWY_INLINE void pull_corner(D d, const Triple<V>& e1, const Triple<V>& e2, const V& scale,
                            Triple<V>& p1, Triple<V>& p2)
{
    using T = hn::TFromD<D>;
    const V one = hn::Set(d, T(1)), tiny = hn::Set(d, T(1e-30));
    const Triple<V> across = cross(e1, e2);
    const V area = hn::Sqrt(dot(across, across));
    const Triple<V> n = times(hn::Div(one, hn::Max(area, tiny)), across);
    const V t = hn::Sqrt(hn::Add(hn::Add(dot(e1, e1), dot(e2, e2)), hn::Add(area, area)));
    const V inverse = hn::Div(one, hn::Max(t, tiny));
    // A sheet pressed together exactly in its plane does not know to which side to buckle. As all
    // real ones, this has a flaw, which shows where a corner has lost area.
    const V flaw = hn::Mul(hn::Set(d, T(1e-8)), hn::Max(hn::Sub(one, area), hn::Zero(d)));
    p1 = times(scale, times(inverse, e1 + cross(e2, n)) - e1 + times(flaw, n));
    p2 = times(scale, times(inverse, e2 + cross(n, e1)) - e2);
}

// `links` holds 4 x 3 rows of `stride` numbers: e along u at 0 and at v, e along v at 0 and at u;
// `scale` the four corners' rows; `rest` three rows or null. `pulls` gets the particles' 4 x 3
// rows.
template <class T>
void pull_cells(std::size_t count, const T* links, const T* scale, const T* rest, T* pulls,
                std::size_t stride)
{
    const hn::CappedTag<T, 8> d;
    using V = hn::Vec<decltype(d)>;
    const std::size_t lanes = hn::Lanes(d);
    const auto triple = [&](const T* from, std::size_t i) HWY_ATTR {
        return Triple<V>{hn::Load(d, from + i), hn::Load(d, from + stride + i),
                         hn::Load(d, from + 2 * stride + i)};
    };
    for (std::size_t i = 0; i < count; i += lanes) {
        Triple<V> e[4], sum[4];
        for (std::size_t k = 0; k < 4; ++k) {
            e[k] = triple(links + 3 * k * stride, i);
            sum[k] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        }
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const std::size_t u = corner >> 1, v = 2 + (corner & 1);
            const V weight = hn::Load(d, scale + corner * stride + i);
            Triple<V> p1, p2;
            if (rest == nullptr) {
                pull_corner(d, e[u], e[v], weight, p1, p2);
            } else {
                const V a = hn::Load(d, rest + i), b = hn::Load(d, rest + stride + i);
                const V c = hn::Load(d, rest + 2 * stride + i);
                Triple<V> q1, q2;
                pull_corner(d, times(a, e[u]) + times(b, e[v]), times(b, e[u]) + times(c, e[v]),
                            weight, q1, q2);
                p1 = times(a, q1) + times(b, q2);
                p2 = times(b, q1) + times(c, q2);
            }
            sum[u] = sum[u] + p1;
            sum[v] = sum[v] + p2;
        }
        // Each link is drawn out by its sum: its far end forth, its near end back.
        const Triple<V> zero{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        const Triple<V> out[4] = {zero - (sum[0] + sum[2]), sum[0] - sum[3], sum[2] - sum[1],
                                  sum[1] + sum[3]};
        for (std::size_t k = 0; k < 4; ++k) {
            T* const to = pulls + 3 * k * stride + i;
            hn::Store(out[k].x, d, to);
            hn::Store(out[k].y, d, to + stride);
            hn::Store(out[k].z, d, to + 2 * stride);
        }
    }
}

}  // namespace membrane_kernel

void pull_cells_float(std::size_t count, const float* links, const float* scale, const float* rest,
                      float* pulls, std::size_t stride)
{
    membrane_kernel::pull_cells(count, links, scale, rest, pulls, stride);
}
void pull_cells_double(std::size_t count, const double* links, const double* scale,
                       const double* rest, double* pulls, std::size_t stride)
{
    membrane_kernel::pull_cells(count, links, scale, rest, pulls, stride);
}

}  // namespace HWY_NAMESPACE
}  // namespace physics
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace physics {

HWY_EXPORT(pull_cells_float);
HWY_EXPORT(pull_cells_double);

namespace {

void pull_cells(std::size_t count, const float* links, const float* scale, const float* rest,
                float* pulls, std::size_t stride)
{
    HWY_DYNAMIC_DISPATCH(pull_cells_float)(count, links, scale, rest, pulls, stride);
}
void pull_cells(std::size_t count, const double* links, const double* scale, const double* rest,
                double* pulls, std::size_t stride)
{
    HWY_DYNAMIC_DISPATCH(pull_cells_double)(count, links, scale, rest, pulls, stride);
}

constexpr std::size_t cells_a_batch = 64;

}  // namespace

std::size_t Membrane::bytes() const
{
    return (cell.size() + held_by.size()) * sizeof(cell[0]) +
           (stiffness.size() + thickness_sq.size() + mass.size()) * sizeof(float);
}

Membrane make_membrane(const geometry::Cubes& cubes, int axis)
{
    Membrane out;
    out.h = cubes.size;
    out.held_by.assign(cubes.corner_count(), {no_cell, no_cell, no_cell, no_cell});
    const auto axes = geometry::plane_axes(axis);
    const unsigned u = 1u << axes[0], v = 1u << axes[1];
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto& corners = cubes.corners[c];
        const auto& cell =
            out.cell.emplace_back(std::array{corners[0], corners[u], corners[v], corners[u | v]});
        for (std::uint32_t k = 0; k < 4; ++k) {
            // Four cells meet at a particle, and it is at a different place of each.
            out.held_by[cell[k]][k] = 4 * std::uint32_t(c) + k;
        }
        out.stiffness.push_back(float(cubes.young[c] * cubes.fill[c] * cubes.size));
        out.thickness_sq.push_back(float(cubes.fill[c] * cubes.fill[c]));
        out.mass.push_back(float(cubes.mass[c]));
    }
    return out;
}

std::vector<std::uint8_t> torn_corners(const Membrane& membrane, int axis,
                                       std::span<const std::uint32_t> broken)
{
    std::vector<std::uint8_t> torn(membrane.cell.size(), 0);
    const auto axes = geometry::plane_axes(axis);
    const auto is_broken = [&](std::uint32_t from, int along) {
        return std::binary_search(broken.begin(), broken.end(), 3 * from + std::uint32_t(along));
    };
    for (std::size_t c = 0; c < torn.size(); ++c) {
        const auto& cell = membrane.cell[c];
        unsigned mask = 0;
        if (is_broken(cell[0], axes[0])) mask |= 0b0011u;  // links are between 0 and u,
        if (is_broken(cell[2], axes[0])) mask |= 0b1100u;  // v and u + v,
        if (is_broken(cell[0], axes[1])) mask |= 0b0101u;  // 0 and v,
        if (is_broken(cell[1], axes[1])) mask |= 0b1010u;  // u and u + v
        torn[c] = std::uint8_t(mask);
    }
    return torn;
}

template <class T>
void MembranePull<T>::pull(const Membrane& membrane, const MembraneState& state,
                           std::span<const T> share, const std::vector<geometry::Vec3>& x)
{
    constexpr std::size_t batch = cells_a_batch;
    const std::size_t cells = membrane.cell.size();
    pulls_.resize(12 * cells);
    geometry::parallel_for(
        (cells + batch - 1) / batch, 16, [&](std::size_t begin, std::size_t end) {
            alignas(64) T links[12 * batch] = {}, scale[4 * batch] = {}, rest[3 * batch] = {},
                                     pulls[12 * batch];
            const T inverse = T(1 / membrane.h), quarter = T(membrane.h / 4);
            for (std::size_t b = begin; b < end; ++b) {
                const std::size_t first = b * batch, count = std::min(batch, cells - first);
                for (std::size_t k = 0; k < count; ++k) {
                    const auto& cell = membrane.cell[first + k];
                    const geometry::Vec3 e[4] = {x[cell[1]] - x[cell[0]], x[cell[3]] - x[cell[2]],
                                                 x[cell[2]] - x[cell[0]], x[cell[3]] - x[cell[1]]};
                    for (std::size_t i = 0; i < 12; ++i) {
                        links[i * batch + k] = inverse * T(e[i / 3][Eigen::Index(i % 3)]);
                    }
                    for (std::size_t i = 0; i < 4; ++i) {
                        const bool torn = !state.torn.empty() && (state.torn[first + k] >> i & 1u);
                        scale[i * batch + k] = torn ? T(0) : quarter * share[first + k];
                    }
                    for (std::size_t i = 0; i < 3 && !state.rest.empty(); ++i) {
                        rest[i * batch + k] = T(state.rest[3 * (first + k) + i]);
                    }
                }
                pull_cells(count, links, scale, state.rest.empty() ? nullptr : rest, pulls, batch);
                for (std::size_t k = 0; k < count; ++k) {
                    T* const to = pulls_.data() + 12 * (first + k);
                    for (std::size_t i = 0; i < 12; ++i) to[i] = pulls[i * batch + k];
                }
            }
        });
}

template class MembranePull<float>;
template class MembranePull<double>;

}  // namespace physics
#endif
